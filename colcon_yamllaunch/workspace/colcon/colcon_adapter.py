# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
All requests to colcon.

The arguments are those of `colcon build`, parsed a second time within the
running command as colcon-rerun and colcon-alias do it, so that the user's
defaults and mixins for `build` hold. The jobs are made and run by the helpers
of colcon's own build verb, for exactly the packages that are asked for:
`--packages-up-to` would build test dependencies too, and `--packages-select`
would insist on them.
"""

from collections.abc import (
    Callable,
    Collection,
    Iterable,
    Iterator,
    Mapping,
    Sequence,
)
from contextlib import (
    contextmanager,
    redirect_stderr,
    redirect_stdout,
    suppress,
)
from copy import copy
from functools import cached_property
from glob import glob, has_magic
import importlib
import io
from itertools import starmap
import json
import logging
import os
from pathlib import Path
import signal
from tempfile import TemporaryDirectory
import time
from typing import Any

from colcon_core import command, location
from colcon_core.environment import create_environment_scripts_only
from colcon_core.event_handler import get_event_handler_extensions
from colcon_core.executor import execute_jobs, OnError
from colcon_core.location import set_default_config_path, set_default_log_path
from colcon_core.package_augmentation import (
    augment_packages,
    get_package_augmentation_extensions,
)
from colcon_core.package_descriptor import PackageDescriptor
from colcon_core.package_discovery import get_package_discovery_extensions
from colcon_core.package_identification import (
    get_package_identification_extensions,
    identify,
    IgnoreLocationException,
)
from colcon_core.package_selection import get_package_descriptors
from colcon_core.subprocess import SIGINT_RESULT
from colcon_core.topological_order import topological_order_packages
from colcon_core.verb import (
    check_and_mark_build_tool,
    check_and_mark_install_layout,
)
from colcon_core.verb.build import BuildVerb
from colcon_yamllaunch.common.errors import UserError, WorkspaceError
from colcon_yamllaunch.workspace.building.build_processes import INTERRUPTED
from colcon_yamllaunch.workspace.colcon.colcon_cache import (
    BuildArguments,
    BuildResult,
    NO_METADATA,
)
from colcon_yamllaunch.workspace.packages.package import (
    closure,
    is_merged,
    Package,
)
from colcon_yamllaunch.workspace.packages.package_index import (
    IGNORED,
    PACKAGE,
    PLAIN,
)
from colcon_yamllaunch.workspace.packages.workspace_root import (
    VIRTUAL_ENVIRONMENT,
)

#: Plain CMake honours no --symlink-install, but this variable since 3.22.
_INSTALL_MODE = {'CMAKE_INSTALL_MODE': 'ABS_SYMLINK_OR_COPY'}
#: Without test dependencies. Since 0.17 colcon needs a mapping here: it takes
#: a plain list of recursive categories for no restriction at all.
_DIRECT = ('build', 'run')
_RECURSIVE = {'build': _DIRECT, 'run': _DIRECT}
#: A group of extensions that is empty: nobody reads what the parser would say
#: of colcon's variables.
_NO_VARIABLES = 'colcon_yamllaunch.no_environment_variable'
#: Arguments of every package's build beside those of the build tasks.
_COMMON = ('build_base', 'install_base', 'merge_install', 'symlink_install')


#: Extensions that run a `setup.py`, or what `attr:` names in a `setup.cfg`.
_RUNNING = (
    'colcon_core.package_augmentation.python',
    'colcon_core.package_identification.python',
    'colcon_python_setup_py.package_augmentation.python_setup_py',
    'colcon_python_setup_py.package_identification.python_setup_py',
    'colcon_ros.package_augmentation.ros_ament_python',
)
logger = logging.getLogger('colcon.colcon_yamllaunch')


class Colcon:
    """
    colcon for one workspace.

    :param build_arguments: Arguments as the user would give `colcon build`
      in the root of the workspace
    :param runs: Whether a `setup.py` may be run to learn what a package is
    :raises UserError: when `colcon build` does not take them
    """

    def __init__(
        self,
        root: Path,
        build_arguments: Sequence[str] = (),
        *,
        runs: bool = True,
    ) -> None:
        # colcon gets its own idea of this path from getcwd()
        self.root = Path(os.path.realpath(root))
        self.build_arguments = tuple(build_arguments)
        self._verb = BuildVerb()
        self._verb.VERB_NAME = 'build'
        self._selected: dict[str, Any] = {}
        self._discovered: set[Any] | None = None
        with self._in_root():
            self._args = self._parse()
        self._folders = Identification(
            self._args, self._verb.task_argument_destinations, runs=runs
        )
        #: See :attr:`Identification.guessed`.
        self.guessed = self._folders.guessed
        self.build_base = self.root / self._args.build_base
        self.install_base = self.root / self._args.install_base
        # colcon would refuse to build; the layout needs to be chosen once only
        self._merge_is_asked = bool(self._args.merge_install)
        #: Whether all packages are installed into one prefix.
        self.merge_install = self._merge_is_asked or is_merged(
            self.install_base
        )
        self._args.merge_install = self.merge_install

    def packages(self) -> tuple[Package, ...]:
        """
        Return the packages of the workspace, ordered by name and path.

        They are those that `colcon build` would find there, and those that
        were selected by their path.

        :raises WorkspaceError: when colcon refuses the arguments
        """
        packages = {_package(desc, self.root) for desc in self._descriptors()}
        return tuple(sorted(packages, key=lambda p: (p.name, p.path)))

    def select(
        self, paths: Iterable[str], cwd: Path | None = None
    ) -> tuple[str, ...]:
        """
        Return the packages at paths, as `colcon build --paths` takes them.

        Beside a package, a path may also name something else of the same
        folder: this is what a shell makes of `folder/*`.

        :param paths: Folders and patterns
        :param cwd: What relative ones are relative to; the current folder if
          not given
        :raises UserError: when there is no package at a path
        """
        base = (cwd or Path.cwd()).absolute()
        found: dict[Path, set[str]] = {}
        given: dict[Path, str] = {}
        for text in paths:
            group, folders = _expand(text, base)
            given.setdefault(group, text)
            names = found.setdefault(group, set())
            names.update(n for f in folders if (n := self._select_one(f)))
        for group, names in found.items():
            if not names:
                folder = given[group].rstrip('/*') or '.'
                raise UserError(
                    f"--paths: there is no package at '{given[group]}'",
                    'name a folder that has a package.xml or a CMakeLists.txt '
                    f"itself, or '{folder}/*' for all packages in a folder",
                )
        return tuple(sorted(set().union(*found.values())))

    def metadata(self, name: str) -> str:
        """
        Return a package's own settings, as text.

        They come from the user's metadata files.
        """
        found = {d.name: self._metadata(d) for d in self._descriptors()}
        return found.get(name, NO_METADATA)

    @property
    def arguments(self) -> BuildArguments:
        """The arguments of a build as far as they are cached."""
        args = self._args
        values = self.values
        base_paths = tuple(values.get('base_paths') or ())
        return BuildArguments(
            build_base=args.build_base,
            install_base=args.install_base,
            merge_install=self._merge_is_asked,
            base_paths=base_paths,
            settings={
                key: _text(values.get(key))
                for key in sorted({*self._tasks, *_COMMON})
            },
            is_plain=bool(base_paths)
            and not any('*' in path for path in base_paths)
            and not any(
                value
                for name, value in values.items()
                if name == 'paths' or name.startswith('packages_')
            ),
        )

    @property
    def values(self) -> dict[str, Any]:
        """All that colcon's parser returned."""
        values: dict[str, Any] = vars(self._args)
        return values

    def identify(self, folder: str) -> tuple[str, str]:
        """
        Return what kind a folder is, and the type of a package.

        :param folder: Relative to the workspace
        """
        with self._in_root():
            kind, desc = self._folders.identify(folder)
        return kind, '' if desc is None else str(desc.type)

    def describe(self) -> dict[str, tuple[Package, str]]:
        """Return the identified packages with their own settings."""
        with self._in_root():
            found = self._folders.describe()
        return {
            folder: (_package(desc, self.root), self._metadata(desc))
            for folder, desc in found.items()
        }

    def restrict_to(self, folders: Iterable[str]) -> None:
        """
        Use only the packages in some folders.

        :param folders: Relative to the workspace
        """
        with self._in_root():
            found = self._folders.describe(folders)
        self._discovered = set(found.values())

    def use_known(self, packages: Mapping[str, Package]) -> None:
        """
        Use packages that were identified before, and no others.

        What colcon knows of them beyond this is not there in the build.

        :param packages: By their folders, relative to the workspace
        """
        self._discovered = set(starmap(_descriptor, packages.items()))

    def mark(self) -> None:
        """
        Mark the build and install folders as colcon's, with their layout.

        :raises WorkspaceError: when the workspace was built in another way
        """
        args = self._args
        with self._in_root(), _build_errors():
            check_and_mark_build_tool(args.build_base)
            check_and_mark_install_layout(
                args.install_base, merge_install=args.merge_install
            )

    def build(
        self, names: Collection[str], environment: Mapping[str, str]
    ) -> BuildResult:
        """
        Build packages, exactly these, in the order of their dependencies.

        What they need beside must have been installed before. The output is
        colcon's own.

        :param environment: The variables that the build sees
        :raises WorkspaceError: when a name is unknown or the workspace was
          built in another way; nothing was made then
        """
        packages = self.packages()
        unknown = sorted(set(names) - {package.name for package in packages})
        if unknown:
            raise WorkspaceError(
                f"no package '{unknown[0]}' in the workspace {self.root}"
            )
        needed = set(closure(packages, names))
        descriptors = {d for d in self._descriptors() if d.name in needed}
        self.mark()
        variables = _INSTALL_MODE | dict(environment)
        with (
            self._in_root(),
            _changed(variables),
            _build_errors(),
        ):
            try:
                return self._build(descriptors, frozenset(names))
            except KeyboardInterrupt:
                return BuildResult(INTERRUPTED, frozenset())

    def warm_up(self, environment: Mapping[str, str]) -> None:
        """
        Fill colcon's caches and load its modules, for builds in forks.

        colcon caches the version of CMake and its templates.

        :param environment: The variables that builds will see
        """
        with (
            TemporaryDirectory() as name,
            self._in_root(),
            _changed(environment),
        ):
            # what fails here fails in the build, which tells of it
            with suppress(Exception):
                package = PackageDescriptor(name)
                package.name = 'package'
                create_environment_scripts_only(Path(name), package)
                self._verb._create_prefix_scripts(name, False)
            with suppress(Exception):
                importlib.import_module('colcon_cmake.task.cmake.build')
                cmake = importlib.import_module('colcon_cmake.task.cmake')
                cmake.get_cmake_version()

    def _parse(self) -> Any:
        parser = command.create_parser(_NO_VARIABLES)
        verbs = {'build': self._verb}
        subparser = command.create_subparser(
            parser, 'colcon', verbs, attribute='verb_name'
        )
        parsers = command.add_parsers_without_arguments(
            parser, subparser, verbs, attribute='verb_name'
        )
        command.add_parser_arguments(parsers['build'], self._verb)
        arguments = ['build', '--symlink-install', *self.build_arguments]
        output = io.StringIO()
        try:
            with redirect_stderr(output), redirect_stdout(output):
                return parser.parse_args(args=arguments)
        except SystemExit:
            given = ' '.join(self.build_arguments)
            _, error, reason = output.getvalue().rpartition(' error: ')
            reason = reason.strip() if error else 'they do not ask for a build'
            raise UserError(
                f"colcon build does not take the arguments '{given}': {reason}"
            ) from None

    def _descriptors(self) -> set[Any]:
        if self._discovered is None:
            folders = self._folders
            names = self._verb.task_argument_destinations
            try:
                with self._in_root():
                    self._discovered = get_package_descriptors(
                        self._args,
                        additional_argument_names=names,
                        discovery_extensions=folders.discovery,
                        identification_extensions=folders.identification,
                        augmentation_extensions=folders.augmentation,
                    )
            except SystemExit as e:
                raise WorkspaceError(f'colcon build: {e}') from None
            except (RuntimeError, AssertionError) as e:
                raise WorkspaceError(str(e)) from e
        return self._discovered | set(self._selected.values())

    def _select_one(self, folder: Path) -> str | None:
        real = os.path.realpath(folder)
        for desc in self._descriptors():
            if os.path.realpath(self.root / desc.path) == real:
                return str(desc.name)
        with self._in_root():
            found = self._folders.describe([real])
        self._selected |= found
        return str(found[real].name) if found else None

    @property
    def _tasks(self) -> set[str]:
        return set(self._verb.task_argument_destinations.values())

    def _metadata(self, desc: Any) -> str:
        tasks = self._tasks
        own = {k: v for k, v in desc.metadata.items() if k in tasks}
        return _text([own, sorted(map(str, desc.hooks))])

    def _build(
        self, descriptors: set[Any], names: frozenset[str]
    ) -> BuildResult:
        args = self._args
        self._verb._create_paths(args)
        try:
            decorators = topological_order_packages(
                descriptors,
                direct_categories=_DIRECT,
                recursive_categories=_RECURSIVE,
            )
        except AssertionError as e:
            raise WorkspaceError(str(e)) from e
        for decorator in decorators:
            decorator.selected = decorator.descriptor.name in names
        jobs, _ = self._verb._get_jobs(
            args, decorators, str(self.install_base)
        )
        context = command.CommandContext(command_name='colcon', args=args)
        on_error = (
            OnError.skip_downstream
            if args.continue_on_error
            else OnError.interrupt
        )
        handlers = get_event_handler_extensions(context=context)
        for handler in handlers.values():
            if hasattr(handler, '_start_time'):
                # not when the arguments were parsed
                handler._start_time = time.monotonic()
        rc = execute_jobs(context, jobs, on_error=on_error)
        # also after a failed build, as colcon does
        self._verb._create_prefix_scripts(
            str(self.install_base), args.merge_install
        )
        done = [
            (str(job.task_context.pkg.name), job.returncode)
            for job in jobs.values()
        ]
        # those that were not begun have no return code, and those that were
        # not ended one of their own
        good = (None, 0, SIGINT_RESULT)
        # a package may have several jobs
        undone = {name for name, code in done if code != 0}
        return BuildResult(
            _exit_code(rc),
            frozenset(name for name, _ in done if name not in undone),
            frozenset(name for name, code in done if code not in good),
        )

    @contextmanager
    def _in_root(self) -> Iterator[None]:
        previous = os.getcwd()
        with _fixed_log_path():
            os.chdir(self.root)
            try:
                yield
            finally:
                os.chdir(previous)


def _text(value: Any) -> str:
    return json.dumps(value, default=str, sort_keys=True)


def _package(desc: Any, root: Path) -> Package:
    needs = desc.dependencies
    return Package(
        name=str(desc.name),
        path=Path(os.path.normpath(root / desc.path)),
        type=str(desc.type),
        build_depends=frozenset(map(str, needs.get('build', ()))),
        run_depends=frozenset(map(str, needs.get('run', ()))),
    )


def _descriptor(folder: str, package: Package) -> Any:
    desc = PackageDescriptor(folder)
    desc.name = package.name
    desc.type = package.type
    desc.dependencies['build'] |= package.build_depends
    desc.dependencies['run'] |= package.run_depends
    return desc


def _expand(text: str, base: Path) -> tuple[Path, list[Path]]:
    path = Path(os.path.normpath(base / Path(text).expanduser()))
    if has_magic(text) and not os.path.exists(path):
        return path, [Path(p) for p in sorted(glob(str(path)))]
    if not os.path.exists(path):
        raise UserError(f"--paths: there is no folder '{text}'")
    return path.parent, [path]


@contextmanager
def _build_errors() -> Iterator[None]:
    try:
        yield
    except RuntimeError as e:
        raise WorkspaceError(str(e)) from e
    except OSError as e:
        raise WorkspaceError(f'cannot build: {e}') from e


def _exit_code(returncode: Any) -> int:
    # make fails with 2 as well, which is the number of SIGINT
    if isinstance(returncode, signal.Signals) or returncode == -signal.SIGINT:
        return INTERRUPTED
    return returncode if isinstance(returncode, int) else 1


@contextmanager
def _changed(variables: Mapping[str, str]) -> Iterator[None]:
    previous = dict(os.environ)
    try:
        os.environ.clear()
        os.environ.update(variables)
        yield
    finally:
        os.environ.clear()
        os.environ.update(previous)


@contextmanager
def _fixed_log_path() -> Iterator[None]:
    # the running command may log to a folder relative to where it was started
    # or named by a variable: neither a chdir nor another environment moves it
    previous = location._log_base_path
    path = location.get_log_path()
    base = os.devnull if path is None else str(path.parent.absolute())
    location._log_base_path = base
    try:
        yield
    finally:
        location._log_base_path = previous


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

    @cached_property
    def discovery(self) -> dict[str, Any]:
        """
        The discovery extensions, which have read their parameters.

        They do so once only, as colcon-metadata would add what its files say
        each time.
        """
        found = {}
        for name, extension in get_package_discovery_extensions().items():
            answer = False
            try:
                answer = extension.has_parameters(args=self._args)
            except Exception as e:
                # colcon goes on without it, too
                logger.error(f'the extension {name} failed: {e}')
                logger.debug('unexpected exception', exc_info=True)
            found[name] = copy(extension)
            found[name].has_parameters = _answering(answer)
        return found

    @property
    def identification(self) -> dict[int, dict[str, Any]]:
        """The identification extensions, by their priorities."""
        return {
            priority: {
                name: extension
                if self._runs or not _is_running(extension)
                else _NameReader(extension, self.guessed)
                for name, extension in extensions.items()
            }
            for priority, extensions in (
                get_package_identification_extensions().items()
            )
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

    def identify(self, folder: str) -> tuple[str, Any]:
        """Return what a folder is, and the bare descriptor of a package."""
        if folder not in self._found:
            self._found[folder] = self._identify(folder)
        return self._found[folder]

    def describe(self, folders: Iterable[str] | None = None) -> dict[str, Any]:
        """
        Return the complete descriptors of the packages in folders.

        :param folders: All that were identified if not given
        """
        folders = list(self._found if folders is None else folders)
        for folder in folders:
            self.identify(folder)
        new = self._found.keys() - self._augmented
        if found := {self._found[folder][1] for folder in new} - {None}:
            augment_packages(
                found,
                additional_argument_names=self._destinations,
                augmentation_extensions=self.augmentation,
            )
        self._augmented |= new
        return {
            folder: desc
            for folder in folders
            if (desc := self._found[folder][1]) is not None
        }

    def _identify(self, folder: str) -> tuple[str, Any]:
        # other extensions need what these have read
        _ = self.discovery
        if os.path.lexists(os.path.join(folder, VIRTUAL_ENVIRONMENT)):
            return IGNORED, None
        try:
            desc = identify(self.identification, folder)
        except IgnoreLocationException:
            return IGNORED, None
        return (PACKAGE, desc) if desc else (PLAIN, None)


class _NameReader:
    """
    Identifies Python packages without running their `setup.py`.

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
        """Set what a folder is; see `PackageIdentificationExtensionPoint`."""
        setup = desc.path / 'setup.py'
        if desc.type not in (None, 'python') or not os.path.isfile(setup):
            return
        # a launch does without them
        from colcon_core.package_identification import python
        from colcon_yamllaunch.workspace.packages import build_files

        if self._only_cfg:
            name = build_files.configured_name(desc.path, ('setup.cfg',))
            if name is None or not python.is_reading_cfg_sufficient(setup):
                return
        else:
            name = build_files.python_name(desc.path)
        desc.type = 'python'
        if desc.name is None:
            desc.name = name or setup.absolute().parent.name
            if name is None:
                self._guessed[desc.name] = setup.absolute()


def _answering(answer: Any) -> Callable[..., Any]:
    return lambda **_: answer


def _is_running(extension: Any) -> bool:
    return type(extension).__module__ in _RUNNING


def set_up_colcon() -> None:
    """
    Set up what colcon's command does before it calls a verb.

    Nothing is logged to files: all is said.
    """
    set_default_config_path(path=Path('~/.colcon').expanduser())
    if os.environ.get('COLCON_HOME'):
        set_default_config_path(path=os.environ['COLCON_HOME'])
    set_default_log_path(base_path=os.devnull)
