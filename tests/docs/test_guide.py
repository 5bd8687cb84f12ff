# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""docs/guide.md works as it stands, from its first command to its last."""

from collections.abc import Callable
from pathlib import Path

from support.transcript import blocks, Reader

GUIDE = Path(__file__).parents[2] / 'docs/guide.md'


def test_the_guide(
    make_reader: Callable[[Path], Reader], tmp_path: Path
) -> None:
    install, *rest = blocks(GUIDE.read_text(encoding='utf-8'))
    # this one has been followed where the tests run
    assert install.kind == 'sh'
    reader = make_reader(tmp_path)
    for block in rest:
        assert block.kind == 'console' or block.path, block
        reader.do(block)
    assert reader.end() == 0
