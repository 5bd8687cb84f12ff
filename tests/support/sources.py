# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The source code of the package, parsed once for all tests about it."""

import ast
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).parents[2] / 'colcon_yamllaunch'


@cache
def modules() -> dict[Path, ast.Module]:
    """Return the modules of the package, by their files."""
    return {
        path: ast.parse(path.read_text(encoding='utf-8'))
        for path in sorted(PACKAGE.rglob('*.py'))
    }
