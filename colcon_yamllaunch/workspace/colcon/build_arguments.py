# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The arguments of `colcon build`, as far as launches need them."""

from collections.abc import Mapping
from dataclasses import field
from typing import Any

from colcon_yamllaunch.common.frozen import dataclass


@dataclass(frozen=True, slots=True)
class BuildArguments:
    """
    What colcon made of the command line, defaults and mixins.

    :param build_base: The build folder, relative to the workspace
    :param install_base: The install folder, relative to the workspace
    :param merge_install: Whether all packages are installed into one prefix
    :param base_paths: The folders that are crawled for packages
    :param settings: What every package is built with, as text
    :param values: All that colcon's parser returned; not in the cache
    """

    build_base: str
    install_base: str
    merge_install: bool
    base_paths: tuple[str, ...]
    settings: dict[str, str]
    values: Mapping[str, Any] = field(default_factory=dict)

    @property
    def are_plain(self) -> bool:
        """
        Whether packages are found by crawling the base paths, all of them.

        Else only colcon knows which ones there are.
        """
        if not self.base_paths or any('*' in path for path in self.base_paths):
            return False
        return not any(
            value
            for name, value in self.values.items()
            if name == 'paths' or name.startswith('packages_')
        )

    def encode(self) -> dict[str, Any]:
        """Return what is to be kept, ready for JSON."""
        return {
            name: getattr(self, name)
            for name in self.__slots__
            if name != 'values'
        }


def decode(values: Mapping[str, Any]) -> BuildArguments:
    """
    Read what :meth:`BuildArguments.encode` returned.

    :raises TypeError: when it is damaged; KeyError likewise
    """
    lists = {
        'base_paths': tuple(values['base_paths']),
        'settings': dict(values['settings']),
    }
    arguments = BuildArguments(**{**values, **lists})
    texts = [
        arguments.build_base,
        arguments.install_base,
        *arguments.base_paths,
        *arguments.settings.values(),
    ]
    if not all(isinstance(text, str) for text in texts):
        raise TypeError('not a text')
    return arguments
