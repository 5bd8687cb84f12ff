# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What colcon makes of single folders.

This is a part of the adapter in `colcon`; the current folder is the workspace
while it is used.
"""

from collections.abc import Iterable
from collections.abc import Mapping
import logging
import os
from pathlib import Path
from typing import Any

from colcon_core.package_augmentation import augment_packages
from colcon_core.package_augmentation import (
    get_package_augmentation_extensions,
)
from colcon_core.package_discovery import get_package_discovery_extensions
from colcon_core.package_identification import (
    get_package_identification_extensions,
)
from colcon_core.package_identification import identify
from colcon_core.package_identification import IgnoreLocationException
from colcon_yamllaunch.workspace.packages.package_folder import IGNORED
from colcon_yamllaunch.workspace.packages.package_folder import PACKAGE
from colcon_yamllaunch.workspace.packages.package_folder import PLAIN
from colcon_yamllaunch.workspace.packages.workspace_root import (
    VIRTUAL_ENVIRONMENT,
)

#: Extensions that run a `setup.py`, or what `attr:` names in a `setup.cfg`.
_RUNNING = (
    'colcon_core.package_augmentation.python',
    'colcon_core.package_identification.python',
    'colcon_python_setup_py.package_augmentation.python_setup_py',
    'colcon_python_setup_py.package_identification.python_setup_py',
    'colcon_ros.package_augmentation.ros_ament_python',
)

logger = logging.getLogger('colcon.colcon_yamllaunch')


class Identification:
    """
    The folders that were identified one by one.

    :param args: The parsed arguments of `colcon build`
    :param destinations: The options of build tasks with their names in args
    :param runs: Whether a `setup.py` may be run
    """

    def __init__(
        self, args: Any, destinations: Mapping[str, str], *, runs: bool = True
    ) -> None:
        self._runs = runs
        #: The packages whose name shows only when their `setup.py` runs, by
        #: the names that they are taken to have.
        self.guessed: dict[str, Path] = {}
        self._args = args
        self._destinations = destinations
        self._found: dict[str, tuple[str, Any]] = {}
        self._augmented: set[str] = set()
        self._discovery: dict[str, Any] = {}

    @property
    def discovery(self) -> dict[str, Any]:
        """The discovery extensions; each is asked for parameters once."""
        if not self._discovery:
            extensions = get_package_discovery_extensions()
            self._discovery = {
                name: _AskedOnce(extension)
                for name, extension in extensions.items()
            }
        return self._discovery

    @property
    def identification(self) -> dict[int, dict[str, Any]]:
        """The identification extensions, by their priorities."""
        found: dict[int, dict[str, Any]]
        found = get_package_identification_extensions()
        if self._runs:
            return found
        return {
            priority: {
                name: _NameReader(extension, self.guessed)
                if _is_running(extension)
                else extension
                for name, extension in extensions.items()
            }
            for priority, extensions in found.items()
        }

    @property
    def augmentation(self) -> dict[str, Any]:
        """The augmentation extensions."""
        found = get_package_augmentation_extensions()
        return {
            name: extension
            for name, extension in found.items()
            if self._runs or not _is_running(extension)
        }

    def identify(self, folder: str) -> tuple[str, str]:
        """Return what kind a folder is, and the type of a package."""
        kind, desc = self._identified(folder)
        return kind, '' if desc is None else str(desc.type)

    def describe(self, folders: Iterable[str] | None = None) -> dict[str, Any]:
        """
        Return the complete descriptors of the packages in folders.

        :param folders: All that were identified if not given
        """
        folders = list(self._found if folders is None else folders)
        for folder in folders:
            self._identified(folder)
        new = self._found.keys() - self._augmented
        self.augment({self._found[folder][1] for folder in new} - {None})
        self._augmented |= new
        return {
            folder: desc
            for folder in folders
            if (desc := self._found[folder][1]) is not None
        }

    def augment(self, descriptors: set[Any]) -> None:
        """Have all extensions complete descriptors."""
        if descriptors:
            self._read_parameters()
            augment_packages(
                descriptors,
                additional_argument_names=self._destinations,
                augmentation_extensions=self.augmentation,
            )

    def _identified(self, folder: str) -> tuple[str, Any]:
        if folder not in self._found:
            self._read_parameters()
            self._found[folder] = self.identify_folder(folder)
        return self._found[folder]

    def identify_folder(self, folder: str) -> tuple[str, Any]:
        """Return what a folder is, and the bare descriptor of a package."""
        if os.path.lexists(os.path.join(folder, VIRTUAL_ENVIRONMENT)):
            return IGNORED, None
        try:
            desc = identify(self.identification, folder)
        except IgnoreLocationException:
            return IGNORED, None
        return (PACKAGE, desc) if desc else (PLAIN, None)

    def _read_parameters(self) -> None:
        # some extensions read files here that others need
        for name, extension in self.discovery.items():
            try:
                extension.has_parameters(args=self._args)
            except Exception as e:
                # colcon goes on without it, too
                logger.error(f'the extension {name} failed: {e}')
                logger.debug('unexpected exception', exc_info=True)


class _AskedOnce:
    """
    A discovery extension that is asked for parameters once only.

    Each time colcon-metadata would add what its files say once more.
    """

    def __init__(self, extension: Any) -> None:
        self._extension = extension
        self._answer: tuple[Any] | None = None

    def has_parameters(self, *, args: Any) -> Any:
        """Say what the extension said the first time."""
        if self._answer is None:
            self._answer = (False,)
            self._answer = (self._extension.has_parameters(args=args),)
        return self._answer[0]

    def __getattr__(self, name: str) -> Any:
        return getattr(self._extension, name)


class _NameReader:
    """
    Identifies Python packages by what is written in their files.

    :param extension: What it stands for: that of setup.cfg, or of setup.py
    :param guessed: Gets the packages of which the name is not written
    """

    def __init__(self, extension: Any, guessed: dict[str, Path]) -> None:
        self.PACKAGE_IDENTIFICATION_NAME = (
            extension.PACKAGE_IDENTIFICATION_NAME
        )
        self._only_cfg = type(extension).__module__.startswith('colcon_core')
        self._guessed = guessed

    def identify(self, desc: Any) -> None:
        """Say what a folder is; see `PackageIdentificationExtensionPoint`."""
        setup = desc.path / 'setup.py'
        if desc.type not in (None, 'python') or not os.path.isfile(setup):
            return
        # a launch does without them
        from colcon_core.package_identification import python
        from colcon_yamllaunch.workspace.packages import python_name

        if self._only_cfg:
            name = python_name.configured_name(desc.path, ('setup.cfg',))
            if name is None or not python.is_reading_cfg_sufficient(setup):
                return
        else:
            name = python_name.written_name(desc.path)
        desc.type = 'python'
        if desc.name is None:
            desc.name = name or setup.absolute().parent.name
            if name is None:
                self._guessed[desc.name] = setup.absolute()


def _is_running(extension: Any) -> bool:
    return type(extension).__module__ in _RUNNING
