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
from typing import Any

from colcon_core.package_augmentation import augment_packages
from colcon_core.package_discovery import get_package_discovery_extensions
from colcon_core.package_identification import (
    get_package_identification_extensions,
)
from colcon_core.package_identification import identify
from colcon_core.package_identification import IgnoreLocationException
from colcon_yamllaunch.workspace.packages.package_folder import IGNORED
from colcon_yamllaunch.workspace.packages.package_folder import PACKAGE
from colcon_yamllaunch.workspace.packages.package_folder import PLAIN

logger = logging.getLogger('colcon.colcon_yamllaunch')


class Identification:
    """
    The folders that were identified one by one.

    :param args: The parsed arguments of `colcon build`
    :param destinations: The options of build tasks with their names in args
    """

    def __init__(self, args: Any, destinations: Mapping[str, str]) -> None:
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
                descriptors, additional_argument_names=self._destinations
            )

    def _identified(self, folder: str) -> tuple[str, Any]:
        if folder not in self._found:
            self._read_parameters()
            self._found[folder] = identify_folder(folder)
        return self._found[folder]

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


def identify_folder(folder: str) -> tuple[str, Any]:
    """Return what kind a folder is, and the bare descriptor of a package."""
    extensions = get_package_identification_extensions()
    try:
        desc = identify(extensions, folder)
    except IgnoreLocationException:
        return IGNORED, None
    return (PACKAGE, desc) if desc else (PLAIN, None)
