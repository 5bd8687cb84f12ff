# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
colcon for one workspace, with a cache of its answers.

Importing and starting colcon takes longer than the rest of a launch. Its
answers are stored below `build/`, with everything that they depend on. If any
of this changes, colcon is asked again.
"""

from collections.abc import (
    Callable,
    Collection,
    Iterable,
    Iterator,
    Mapping,
    Sequence,
)
import json
import os
from pathlib import Path
import sys
from typing import Any, ClassVar, TYPE_CHECKING

from colcon_core.extension_point import get_extension_points
import colcon_yamllaunch
from colcon_yamllaunch.common.codec import from_json, to_json
from colcon_yamllaunch.common.files import read_json, write_json
from colcon_yamllaunch.common.fingerprint import (
    are_settled,
    Fingerprint,
    fingerprints,
)
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.workspace.packages.package import (
    closure,
    is_merged,
    Package,
)
from colcon_yamllaunch.workspace.packages.package_index import PackageIndex
from colcon_yamllaunch.workspace.packages.workspace_root import TRUST

if TYPE_CHECKING:
    from colcon_yamllaunch.workspace.colcon.colcon_adapter import Colcon


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
#: The name of the cache, below the workspace's `build/`. With another build
#: folder there is none: only colcon knows which one it is.
CACHE_NAME = '.colcon_launch.index.json'
#: To be raised when what is in it changes.
CACHE_VERSION = 3
#: The own settings of a package that has none.
NO_METADATA = '[{}, []]'
#: What is built by its name, type, dependencies and own settings alone, and
#: by what. Python packages need more, and to find that out takes colcon longer
#: than many a build.
_SIMPLE_TYPES = frozenset(('cmake', 'ros.cmake', 'ros.ament_cmake'))
_SIMPLE_TASKS = ('colcon_cmake.', 'colcon_ros.')


@dataclass(frozen=True, slots=True)
class BuildArguments:
    """
    What colcon made of the command line, defaults and mixins.

    :param build_base: The build folder, relative to the workspace
    :param install_base: The install folder, relative to the workspace
    :param merge_install: Whether all packages are installed into one prefix
    :param base_paths: The folders that are crawled for packages
    :param settings: What every package is built with, as text
    :param is_plain: Whether packages are found by crawling the base paths, all
      of them; else only colcon knows which ones there are
    """

    build_base: str
    install_base: str
    merge_install: bool
    base_paths: tuple[str, ...]
    settings: dict[str, str]
    is_plain: bool = True


@dataclass(frozen=True, slots=True)
class BuildResult:
    """
    How a build ended.

    :param returncode: 0, what colcon returned, or `INTERRUPTED`
    :param built: The names of the packages that were built successfully
    :param failed: The names of those that were begun in vain, if known
    """

    returncode: int
    built: frozenset[str]
    failed: frozenset[str] = frozenset()


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
        'variables': {
            name: value
            for name, value in sorted(environment.items())
            if name == 'HOME'
            or (name.startswith('COLCON_') and name not in _OTHER_VARIABLES)
        },
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


def configuration_folder(environment: Mapping[str, str]) -> Path:
    """Return colcon's configuration folder (`COLCON_HOME`)."""
    given = environment.get('COLCON_HOME')
    return Path(given or '~/.colcon').expanduser()


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


class CachedColcon:
    """
    colcon for one workspace, which remembers what `Colcon` said.

    :param build_arguments: Arguments as the user would give `colcon build`
      in the root of the workspace
    :param runs: Whether a `setup.py` may be run to learn what a package is;
      what is learned without is not kept
    :raises UserError: when `colcon build` does not take them
    """

    #: colcon as a process before a fork has asked it, and for what.
    _warm: 'ClassVar[tuple[Colcon, str] | None]' = None

    def __init__(
        self,
        root: Path,
        build_arguments: Sequence[str] = (),
        *,
        runs: bool = True,
    ) -> None:
        self._runs = runs
        self.root = Path(os.path.realpath(root))
        #: Further arguments for `colcon build`.
        self.build_arguments = tuple(build_arguments)
        self._colcon: Colcon | None = None
        self._index: PackageIndex | None = None
        self._packages: dict[str, Package] = {}
        self._metadata: dict[str, str] = {}
        #: Is called when packages were built, or failed to.
        self.when_built: Callable[[], object] = lambda: None
        # before anything is asked, so that a change in between will show
        self._key = cache_key(self.root, self.build_arguments, os.environ)
        # whether any later change will show in it
        self._is_settled = self._key is not None and are_settled(
            [*self._key['installed'].values(), *self._key['files'].values()]
        )
        self._cache = self._read()
        if not self._cache:
            self._arguments = self._ask().arguments
        self.build_base = self.root / self._arguments.build_base
        self.install_base = self.root / self._arguments.install_base
        #: Whether all packages are installed into one prefix.
        self.merge_install = self._arguments.merge_install or is_merged(
            self.install_base
        )

    @property
    def common_settings(self) -> Mapping[str, str]:
        """What every package is built with, as text."""
        return self._arguments.settings

    def packages(self) -> tuple[Package, ...]:
        """
        Return the packages of the workspace, ordered by name and path.

        :raises WorkspaceError: when colcon refuses the arguments
        """
        if self._is_left_to_colcon:
            return self._ask().packages()
        if self._index is None:
            self._index = self._find()
            self._packages = self._index.packages()
            self._metadata = self._index.metadata()
            self._write()
        packages = self._packages.values()
        return tuple(sorted(packages, key=lambda p: (p.name, p.path)))

    def select(
        self, paths: Iterable[str], cwd: Path | None = None
    ) -> tuple[str, ...]:
        """
        Return the packages at paths, as `colcon build --paths` takes them.

        :raises UserError: when there is no package at a path
        """
        # what is at a path need not be among what is crawled
        self._key = None
        return self._ask().select(paths, cwd)

    @property
    def guessed(self) -> Mapping[str, Path]:
        """The `setup.py` of packages whose names are guessed, by these."""
        return {} if self._colcon is None else self._colcon.guessed

    def settings(self, name: str) -> dict[str, str]:
        """Return the arguments that a package is built with, as text."""
        metadata = self._metadata.get(name, NO_METADATA)
        if self._is_left_to_colcon:
            metadata = self._ask().metadata(name)
        return self._arguments.settings | {
            'merge_install': 'true' if self.merge_install else 'false',
            'metadata': metadata,
        }

    def warm_up(self, environment: Mapping[str, str]) -> None:
        """
        Load what a build takes, for forks of this process.

        A fork that is about the same workspace need not ask colcon again for
        what its arguments mean; see `Colcon.warm_up`, too.

        :param environment: The variables that builds will see
        """
        colcon = self._ask()
        colcon.warm_up(environment)
        if self._key is not None:
            CachedColcon._warm = colcon, self._depends_on()

    def mark(self) -> None:
        """
        Mark the build and install folders as colcon's, with their layout.

        :raises WorkspaceError: when the workspace was built in another way
        """
        self._ask().mark()

    def build(
        self, names: Collection[str], environment: Mapping[str, str]
    ) -> BuildResult:
        """
        Build packages, exactly these, in the order of their dependencies.

        :param environment: The variables that the build sees
        :raises WorkspaceError: when a name is unknown or the workspace was
          built in another way
        """
        colcon = self._ask()
        if not self._is_left_to_colcon:
            needed = set(closure(self.packages(), names))
            known = {
                folder: package
                for folder, package in self._packages.items()
                if package.name in needed
            }
            if all(map(self._is_simple, names)):
                colcon.use_known(known)
            else:
                colcon.restrict_to(known)
        result = colcon.build(names, environment)
        self.when_built()
        # there may have been no folder to write to before
        self._write()
        return result

    def base_paths(self) -> tuple[Path, ...]:
        """Return the folders that are crawled for packages."""
        paths = self._arguments.base_paths or ('.',)
        return tuple(self.root / path for path in paths)

    @property
    def _is_left_to_colcon(self) -> bool:
        """Whether only colcon can tell which packages there are."""
        return self._key is None or not self._arguments.is_plain

    def _is_simple(self, name: str) -> bool:
        """Return whether colcon builds a package by what is known of it."""
        assert self._key is not None
        tasks = self._key['extensions'][BUILD_TASKS]
        types = {p.type for p in self._packages.values() if p.name == name}
        return (
            self._metadata.get(name, NO_METADATA) == NO_METADATA
            and types <= _SIMPLE_TYPES
            and all(tasks.get(t, '').startswith(_SIMPLE_TASKS) for t in types)
        )

    def _ask(self) -> 'Colcon':
        if self._colcon is None:
            # takes longer than all of a launch that needs no build
            from colcon_yamllaunch.workspace.colcon.colcon_adapter import (
                Colcon,
            )

            self._colcon = self._warm_one() or Colcon(
                self.root, self.build_arguments, runs=self._runs
            )
        return self._colcon

    def _warm_one(self) -> 'Colcon | None':
        """Return what :meth:`warm_up` has kept, if it still holds."""
        if CachedColcon._warm is None or not self._cache:
            return None
        colcon, depends_on = CachedColcon._warm
        is_same = (
            depends_on == self._depends_on()
            and colcon.merge_install == self.merge_install
        )
        return colcon if is_same else None

    def _depends_on(self) -> str:
        """Return all that colcon's idea of the arguments depends on."""
        named = self._named()['named']
        return json.dumps([str(self.root), self._runs, self._key, named])

    def _find(self) -> PackageIndex:
        index = PackageIndex(
            self.root,
            self._arguments.base_paths,
            os.environ,
            everywhere=self._named()['everywhere'],
        )
        index.find(self._cache.get('folders', {}), self._ask)
        return index

    def _named(self) -> dict[str, Any]:
        """Return what follows from files that the arguments name."""
        if self._cache:
            return {key: self._cache[key] for key in ('named', 'everywhere')}
        values = self._ask().values
        named = named_files(self.root, values)
        # the user's files with metadata of packages (colcon-metadata)
        folder = configuration_folder(os.environ) / 'metadata'
        files = [path for path, found in named.items() if found is not None]
        everywhere = any(
            path.endswith('.meta') for path in (*_files(str(folder)), *files)
        )
        return {'named': named, 'everywhere': everywhere}

    def _read(self) -> dict[str, Any]:
        """Return the cache if all still holds, else nothing."""
        cache = read_cache(self.root)
        try:
            arguments = from_json(BuildArguments, cache['arguments'])
            holds = (
                _is_same(cache['key'], self._key)
                and _is_same(cache['named'], fingerprints(cache['named']))
                and isinstance(cache['everywhere'], bool)
            )
        except (KeyError, TypeError, AttributeError, ValueError):
            return {}
        self._arguments = arguments
        return cache if holds else {}

    def _write(self) -> None:
        index = self._index
        path = _path(self.root)
        if (
            index is None
            or self._key is None
            or not self._runs
            or (self._cache and not index.changed)
            or self.build_base != path.parent
            or not os.path.isdir(self.build_base)
        ):
            return
        named = self._named()
        if not self._cache and not (
            self._is_settled and are_settled(named['named'].values())
        ):
            return
        # without it colcon is asked again, which is no harm
        write_json(
            path,
            {
                'version': CACHE_VERSION,
                'key': self._key,
                **named,
                'arguments': to_json(self._arguments),
                'folders': index.cacheable_entries(),
            },
        )


def read_cache(root: Path) -> dict[str, Any]:
    """
    Return the cache of a workspace, whether it still holds or not.

    It has the folders among it, or is empty.
    """
    cache = read_json(_path(root))
    try:
        is_whole = cache['version'] == CACHE_VERSION and all(
            isinstance(entry, dict) for entry in cache['folders'].values()
        )
    except (KeyError, TypeError, AttributeError):
        return {}
    return cache if is_whole else {}


def _path(root: Path) -> Path:
    return root / 'build' / CACHE_NAME


def _is_same(stored: object, now: object) -> bool:
    # fingerprints come back as lists
    return json.dumps(stored) == json.dumps(now)
