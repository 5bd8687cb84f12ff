# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The command line of `colcon create`."""

from pathlib import Path
from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.verb.cli.option_parser import read_options
from colcon_yamllaunch.verb.cli.option_parser import refuse_unknown

_USAGE = 'usage: colcon create PKG [options]'


@dataclass(frozen=True, slots=True)
class CreateOptions:
    """What the user asks for; the options by their keys in the table."""

    package: str
    build_type: str
    dependencies: tuple[str, ...] = ()
    node: str | None = None
    add_node: str | None = None
    license: str | None = None
    description: str | None = None
    maintainer_name: str | None = None
    maintainer_email: str | None = None
    destination: Path | None = None


def parse_create_options(known: Any) -> CreateOptions:
    """
    Read the whole command line.

    :raises UserError: when it makes no sense
    """
    words = known.positionals
    refuse_unknown(words, 'create')
    if not words:
        if known.dependencies:
            raise UserError(
                '--dependencies took all that follows it',
                'put it behind the name of the package',
            )
        raise UserError('there is no name for the package', _USAGE)
    if len(words) > 1:
        raise UserError(
            f"'{words[1]}' is one word too many: one package is made at a "
            'time',
            _USAGE,
        )
    return CreateOptions(words[0], **read_options(known, 'create'))
