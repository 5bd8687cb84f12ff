# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What the answers of colcon depend on beside the packages themselves.

The cache holds only while all of this is the same.
"""

from collections.abc import Iterator
from collections.abc import Mapping
from collections.abc import Sequence
import os
from pathlib import Path
import sys
from typing import Any

from colcon_core.extension_point import get_extension_points
import colcon_yamllaunch
from colcon_yamllaunch.common.fingerprint import are_settled
from colcon_yamllaunch.common.fingerprint import Fingerprint
from colcon_yamllaunch.common.fingerprint import fingerprints
from colcon_yamllaunch.workspace.packages.trust import TRUST

#: How many configuration files are read; with more nothing is cached.
MAXIMUM_FILES = 1000

#: Extensions whose answers depend on what is compared here and in the index.
_KNOWN = (
    *('colcon_argcomplete', 'colcon_cmake', 'colcon_core', 'colcon_defaults'),
    *('colcon_metadata', 'colcon_mixin', 'colcon_package_information'),
    *('colcon_package_selection', 'colcon_python_setup_py'),
    *('colcon_recursive_crawl', 'colcon_ros'),
    # our own reads the words of `colcon run` only
    'colcon_yamllaunch',
)
#: The groups of extensions that have a say in arguments and packages.
_GROUPS = (
    'colcon_core.argument_parser',
    'colcon_core.package_augmentation',
    'colcon_core.package_discovery',
    'colcon_core.package_identification',
)
#: The group of the extensions that build packages, by their types.
BUILD_TASKS = 'colcon_core.task.build'
#: Variables of colcon that make no difference: where it logs, what a sourced
#: install space sets, and whose workspaces are used.
_OTHER_VARIABLES = (
    *('COLCON_CURRENT_PREFIX', 'COLCON_DEFAULT_EXECUTOR', 'COLCON_LOG_LEVEL'),
    *('COLCON_LOG_PATH', 'COLCON_PREFIX_PATH', 'COLCON_TRACE', TRUST),
)
#: The defaults of a workspace (colcon-defaults).
_WORKSPACE_DEFAULTS = 'colcon_defaults.yaml'


def cache_key(
    root: Path, build_arguments: Sequence[str], environment: Mapping[str, str]
) -> dict[str, Any] | None:
    """
    Return what colcon's answers for a workspace depend on, ready for JSON.

    That is the installed extensions, Python, the variables and configuration
    files of colcon, and the arguments given. It is None when there are
    extensions that nothing is known about, when some are blocked, or when
    there are too many files.
    """
    extensions = {
        group: dict(sorted(get_extension_points(group).items()))
        for group in (*_GROUPS, BUILD_TASKS)
    }
    values = (v for group in _GROUPS for v in extensions[group].values())
    if not all(value.partition('.')[0] in _KNOWN for value in values):
        return None
    if environment.get('COLCON_EXTENSION_BLOCKLIST'):
        return None
    files = _configuration_files(root, environment)
    if files is None:
        return None
    return {
        'program': colcon_yamllaunch.__version__,
        'python': [sys.executable, sys.version],
        'root': str(root),
        'arguments': list(build_arguments),
        'variables': _variables(environment),
        'extensions': extensions,
        # an installed or removed distribution shows in its folder
        'installed': fingerprints(
            path
            for path in sys.path
            # setuptools adds what is its own when colcon imports it
            if path and not path.endswith('setuptools/_vendor')
        ),
        'files': fingerprints(files),
    }


def is_settled(values: Mapping[str, Any]) -> bool:
    """Tell whether any later change will show in :func:`cache_key`."""
    return are_settled(
        [*values['installed'].values(), *values['files'].values()]
    )


def configuration_folder(environment: Mapping[str, str]) -> Path:
    """Return colcon's configuration folder (`COLCON_HOME`)."""
    given = environment.get('COLCON_HOME')
    return Path(given or '~/.colcon').expanduser()


def metadata_files(environment: Mapping[str, str]) -> list[str]:
    """Return the user's files with metadata of packages (colcon-metadata)."""
    folder = configuration_folder(environment) / 'metadata'
    return [p for p in _files(str(folder)) if p.endswith('.meta')]


def _variables(environment: Mapping[str, str]) -> dict[str, str]:
    return {
        name: value
        for name, value in sorted(environment.items())
        if name == 'HOME'
        or (name.startswith('COLCON_') and name not in _OTHER_VARIABLES)
    }


def _configuration_files(
    root: Path, environment: Mapping[str, str]
) -> list[str] | None:
    folders = [str(configuration_folder(environment))]
    # relative ones start from the root, as colcon is asked there
    mixins = environment.get('COLCON_MIXIN_PATH', '').split(os.pathsep)
    folders += [str(root / path) for path in mixins if path]
    files = [str(root / _WORKSPACE_DEFAULTS)]
    defaults = environment.get('COLCON_DEFAULTS_FILE')
    if defaults:
        files.append(str(root / defaults))
    for folder in folders:
        for file in _files(folder):
            files.append(file)
            if len(files) > MAXIMUM_FILES:
                return None
    return files


def _files(folder: str) -> Iterator[str]:
    for current, _, names in os.walk(folder, followlinks=True):
        for name in sorted(names):
            yield os.path.join(current, name)


def named_files(
    root: Path, values: Mapping[str, Any]
) -> dict[str, Fingerprint | None]:
    """
    Return the fingerprints of files that arguments name.

    :param root: What relative paths start from
    """
    texts = [t for value in values.values() for t in _texts(value)]
    paths = {str(root / text) for text in texts}
    files = sorted(path for path in paths if os.path.isfile(path))
    for text in _texts(values.get('metas')):
        files += [str(root / text), str(root / text / 'colcon.meta')]
    # folders are crawled, or made by builds
    return fingerprints(path for path in files if not os.path.isdir(path))


def _texts(value: Any) -> list[str]:
    values = value if isinstance(value, (list, tuple)) else [value]
    return [v for v in values if isinstance(v, str) and '\0' not in v]
