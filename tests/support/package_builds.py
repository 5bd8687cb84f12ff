# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Builds of a package that are recorded, without colcon and CMake."""

from collections.abc import Callable
from pathlib import Path

from colcon_yamllaunch.workspace.freshness.build_products import Products
from colcon_yamllaunch.workspace.freshness.build_record import (
    BuildContext,
    Decision,
)
from colcon_yamllaunch.workspace.freshness.freshness import Freshness
from colcon_yamllaunch.workspace.packages.package import Package
from support.file_clock import let_files_settle

_CONTEXT = BuildContext({}, {}, {})


class PackageBuilds:
    """
    A package with a source, and builds of it.

    :param root: The workspace
    """

    def __init__(self, root: Path, package_type: str = 'cmake') -> None:
        self.root = root
        self.package = Package('flow', root / 'src/flow', package_type)
        self.products = Products(root / 'build', root / 'install', False)
        for name in ('setup.sh', 'local_setup.sh', '_local_setup_util_sh.py'):
            self.write(f'install/{name}')
        self.write('src/flow/main.c', 'one')
        self.write('src/flow/CMakeLists.txt', 'project(flow)')
        self.context = _CONTEXT
        self.variables: dict[str, str] = {}

    def write(self, path: str, text: str = '', mode: int = 0o644) -> Path:
        """Write a file, and wait until any further change would show."""
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        file.chmod(mode)
        let_files_settle(self.root)
        return file

    def decide(self) -> Decision:
        """Decide in a new launch."""
        return Freshness(self.products, self.variables).decide(
            self.package, self.context
        )

    @property
    def why(self) -> str:
        """The reason to build, empty if there is none."""
        return self.decide().reason

    def build(
        self, compiler: Callable[[], object] = bool, *, fails: bool = False
    ) -> None:
        """
        Build it.

        :param compiler: What happens during the build
        :param fails: Whether the build fails
        """
        freshness = Freshness(self.products, self.variables)
        mode = freshness.decide(self.package, self.context).mode
        attempt = freshness.prepare(self.package, mode)
        compiler()
        if fails:
            freshness.record_failure(attempt)
        else:
            freshness.record_success(attempt, self.context)
        let_files_settle(self.root)
