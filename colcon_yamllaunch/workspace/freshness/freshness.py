# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Whether what was built last still is what a build would give now.

The measure is a build from scratch: where the build tools would give another
outcome than that, because they compare times or keep earlier answers, less of
the last build is kept. In doubt a package is built.

What makes a package stale: a file of its source, headers among them
(`source_changes`); a file elsewhere that its build read, such as a header of
the system (`build_inputs`); a package that it needs (`building.update`); the
environment and arguments of the build (`build_context`); and products that
are gone or not as they were built (`build_products`, `product_states`).
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import field, replace
import os
from pathlib import Path
import time
from typing import TYPE_CHECKING
import uuid

from colcon_yamllaunch.common.errors import WorkspaceError
from colcon_yamllaunch.common.fingerprint import Fingerprint, TICK
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.text_files import text_of
from colcon_yamllaunch.workspace.freshness.build_products import (
    ARGUMENTS,
    compare,
    Comparison,
    CONFIGURED,
    is_compiled,
    is_same,
    Products,
    remove_folder,
)
from colcon_yamllaunch.workspace.freshness.build_record import (
    build_of,
    BuildContext,
    BuildMode,
    changed_variables,
    context_changes,
    DamagedRecordError,
    Decision,
    own_variables,
    read_record,
    Reason,
    Record,
    RECORD_NAME,
    write_record,
)
from colcon_yamllaunch.workspace.freshness.source_changes import (
    Change,
    changes,
    INTERFACE_SUFFIXES,
    Kind,
    link_project,
    live_files,
    remove_dangling,
    snapshot,
    SOURCE_SUFFIXES,
    with_changes,
    with_sources,
)
from colcon_yamllaunch.workspace.packages.package import Package

if TYPE_CHECKING:
    from colcon_yamllaunch.workspace.freshness.build_inputs import BuildInputs

#: What colcon writes for all packages together (colcon-core).
_PREFIX_SCRIPTS = ('setup.sh', 'local_setup.sh', '_local_setup_util_sh.py')
#: How many products are named that are not as they were.
_SHOWN_PRODUCTS = 8
_UNKNOWN = 'there is no record of a successful build of it'
_FAILED = 'no successful build: the last one failed or was interrupted'
_CUT_OFF = 'no successful build: the last one was cut off'


@dataclass(frozen=True, slots=True)
class Attempt:
    """
    A build that has begun.

    :param record: The record so far
    :param started: When it began, by the clock of the build folder
      (nanoseconds)
    :param listed: What the last installation listed
    :param links: The links that were removed, with their targets
    """

    package: Package
    record: Record
    started: int
    listed: frozenset[Path] = frozenset()
    links: Mapping[Path, Path] = field(default_factory=dict)


class Freshness:
    """
    Decides which packages are stale, by the records of their builds.

    :param environment: The variables of builds
    """

    def __init__(
        self, products: Products, environment: Mapping[str, str]
    ) -> None:
        self._products = products
        self._environment = environment
        self._records: dict[str, Record | None] = {}

    def decide(
        self,
        package: Package,
        context: BuildContext,
        before: Sequence[Reason] = (),
        own: Collection[str] = (),
    ) -> Decision:
        """
        Decide whether a package has to be built, and why.

        :param context: What the build would depend on now
        :param before: Reasons that follow from packages that are built before;
          one that was never built needs none of them
        :param own: The packages of the workspace that its build may need
        """
        name = package.name
        try:
            record = self._record(name)
        except DamagedRecordError:
            return Decision(name, (Reason(_UNKNOWN, BuildMode.CLEAN),))
        if record is None:
            reason = Reason('never built')
            if os.path.isdir(self._products.build(name)):
                reason = Reason(_UNKNOWN, BuildMode.CONFIGURE)
            return Decision(name, (reason,))
        if _is_apart(package, record, context, before, own):
            then = {n: record.context.dependencies[n] for n in own}
            context = replace(
                context, dependencies={**context.dependencies, **then}
            )
            before = ()
        reasons = [*self._reasons(package, record, context)]
        if record.built_at:
            reasons += _of_others(record, before)
        return Decision(name, tuple(reasons), record.built_at or None)

    def prepare(self, package: Package, mode: BuildMode) -> Attempt:
        """
        Get ready for a build: remove what must not stay, record the source.

        Links to source files that are gone are removed, as builds trip over
        them. The attempt is for :meth:`finish` or :meth:`give_up`.

        :param mode: What is to stay
        :raises WorkspaceError: when something cannot be removed
        """
        name = package.name
        before = self._known_record(name)
        known = before or Record(str(package.path), {})
        record = replace(
            known,
            source=str(package.path),
            files=snapshot(package.path, known.files),
            mode=mode,
            id=uuid.uuid4().hex,
            succeeded=False,
            finished=0,
        )
        if mode >= BuildMode.CLEAN or before is None:
            record = replace(
                record, clean_id=record.id, interface_id=record.id
            )
        elif mode > BuildMode.COMPILE:
            record = replace(record, interface_id=record.id)
        self._write(name, record)
        listed = frozenset(self._products.listed(name))
        links = self._make_room(package, mode, known)
        if not os.path.exists(self._path(name)):
            # it was removed with the build folder
            self._write(name, record)
        if package.type.endswith('python'):
            link_project(package.path, self._products.build(name))
        return Attempt(package, record, self._now(name), listed, links)

    def finish(self, attempt: Attempt, context: BuildContext) -> None:
        """
        Write down that a package was built successfully.

        :param context: What the build depended on
        :raises WorkspaceError: when what was written at its begin is gone
        """
        package, record = attempt.package, attempt.record
        name = package.name
        products = self._products
        if record.mode >= BuildMode.CONFIGURE:
            products.prune(name, attempt.listed)
        build = products.build(name)
        self._refuse_removed(name)
        inputs = self._inputs(package)
        record = self._with_sources(attempt, inputs)
        before = attempt.record.files
        own = [file for file in before if not Path(file).is_absolute()]
        now = time.time_ns()
        listed = products.installed(name)
        installed = products.states(name, record.installed)
        self._write(
            name,
            replace(
                record,
                succeeded=True,
                finished=now,
                built_at=now,
                live=live_files(package.path, own, build, listed, inputs),
                installed=installed,
                products=products.built(name, installed, record.products),
                traces=products.traces(name),
                arguments=self._arguments(name),
                variables=own_variables(
                    inputs.variables(),
                    self._environment,
                    products.install_base,
                ),
                context=context,
            ),
        )

    def _refuse_removed(self, name: str) -> None:
        # whoever removed the record may have removed more
        if not os.path.isfile(self._path(name)):
            raise WorkspaceError(
                f'{self._path(name)} was removed while {name} was built, so '
                'what it was built from is not known',
                'launch again',
            )

    def give_up(self, attempt: Attempt) -> None:
        """Write down that the build of a package ended without success."""
        package = attempt.package
        self._products.restore_links(attempt.links)
        record = self._with_sources(attempt, self._inputs(package))
        self._write(package.name, replace(record, finished=time.time_ns()))

    def last_build(self, name: str) -> str | None:
        """Return the last successful build of a package, or None."""
        record = self._known_record(name)
        if record is None or not record.succeeded:
            return None
        return build_of(record.clean_id, record.interface_id, record.id)

    def _with_sources(self, attempt: Attempt, inputs: 'BuildInputs') -> Record:
        path, products = attempt.package.path, self._products
        own = (path, products.build_base, products.install_base)
        read = inputs.outside(own)
        return with_sources(attempt.record, path, read, attempt.started)

    def _inputs(self, package: Package) -> 'BuildInputs':
        # most launches need not know what builds read
        from colcon_yamllaunch.workspace.freshness.build_inputs import (
            BuildInputs,
        )

        return BuildInputs(package.path, self._products.build(package.name))

    def _now(self, name: str) -> int:
        # of what has just been written
        with suppress(OSError):
            return self._path(name).stat().st_mtime_ns
        return time.time_ns() - TICK

    def _path(self, name: str) -> Path:
        return self._products.build(name) / RECORD_NAME

    def _record(self, name: str) -> Record | None:
        if name not in self._records:
            self._records[name] = read_record(self._path(name))
        return self._records[name]

    def _known_record(self, name: str) -> Record | None:
        try:
            return self._record(name)
        except DamagedRecordError:
            return None

    def _write(self, name: str, record: Record) -> None:
        write_record(self._path(name), record)
        self._records.pop(name, None)

    def _reasons(
        self, package: Package, record: Record, context: BuildContext
    ) -> Iterator[Reason]:
        if record.source != str(package.path):
            text = f'it was built from {record.source}'
            yield Reason(text, BuildMode.CLEAN)
            return
        if not record.succeeded:
            yield self._unsuccessful(package.name, record)
        if record.built_at:
            found = context_changes(record.context, context)
            yield from _of_others(record, found)
            yield from changed_variables(
                record.variables,
                self._environment,
                self._products.install_base,
            )
        edits = changes(package.path, record.files, record.live)
        if edits and record.succeeded and package.type.endswith('cmake'):
            record, edits = self._without_documents(package, record, edits)
        yield from self._changed_source(package, record, edits)
        if record.succeeded:
            yield from self._changed_products(package, record, edits)

    def _without_documents(
        self, package: Package, record: Record, found: tuple[Change, ...]
    ) -> tuple[Record, tuple[Change, ...]]:
        """Leave out what the build cannot have to do with, for good."""
        # most launches find nothing changed
        from colcon_yamllaunch.workspace.packages.build_files import (
            is_document,
            may_be_meant,
        )

        documents = [c for c in found if is_document(c.path)]
        if not documents:
            return record, found
        inputs = self._inputs(package)
        unread = [
            c
            for c in documents
            if not inputs.may_take_in(c.path)
            and not may_be_meant(c.path, [record.arguments])
        ]
        if not unread:
            return record, found
        now = with_changes(package.path, record.files, unread)
        record = replace(record, files=now)
        # so that it need not be found out again
        self._write(package.name, record)
        return record, tuple(c for c in found if c not in unread)

    def _unsuccessful(self, name: str, record: Record) -> Reason:
        if not record.finished:
            was_begun = record.traces != self._products.traces(name)
            # a compiler that was killed leaves files that look complete
            mode = BuildMode.CLEAN if was_begun else BuildMode.CONFIGURE
            return Reason(_CUT_OFF, mode)
        if _generates(record) and not record.built_at:
            # nothing tells what it was generated from
            return Reason(_FAILED, BuildMode.CLEAN)
        return Reason(
            _FAILED, min(BuildMode(record.mode), BuildMode.CONFIGURE)
        )

    def _changed_source(
        self, package: Package, record: Record, found: tuple[Change, ...]
    ) -> Iterator[Reason]:
        if not found:
            return
        inputs = self._inputs(package)
        generates = _generates(record)
        for change in found:
            mode = _mode_for(change, package, record, inputs)
            if generates and mode > BuildMode.BUILD:
                mode = BuildMode.CLEAN
            yield Reason(str(change), mode)

    def _changed_products(
        self, package: Package, record: Record, found: tuple[Change, ...]
    ) -> Iterator[Reason]:
        name = package.name
        built = compare(self._products.build(name), record.products)
        installed = compare(self._products.install_base, record.installed)
        if record.traces != self._products.traces(name):
            mode = self._built_by_others(name, record, bool(found))
            if mode is not None:
                yield Reason('something else built it since', mode)
            return
        if built.differing:
            mode = self._mode_for_damage(package, record, built.differing)
            for product in built.differing[:_SHOWN_PRODUCTS]:
                is_missing = product in built.missing
                what = 'is missing' if is_missing else 'is not as it was built'
                text = f'{product} {what} in {self._products.build(name)}'
                yield Reason(text, mode, is_damage=True)
        yield from self._changed_install(installed, record, bool(found))
        if (built.now or installed.now) and not (
            built.differing or installed.differing
        ):
            # so that they need not be read again
            now = replace(
                record,
                products=built.now or record.products,
                installed=installed.now or record.installed,
            )
            self._write(name, now)

    def _changed_install(
        self, installed: Comparison, record: Record, is_edited: bool
    ) -> Iterator[Reason]:
        base = self._products.install_base
        missing = [p for p in _PREFIX_SCRIPTS if not os.path.exists(base / p)]
        if not is_edited:
            # else a link may be gone because its target is
            missing += installed.missing
            missing += [
                relative
                for relative, found in record.installed.items()
                if found.digest.startswith('link')
                and relative not in installed.missing
                and not os.path.exists(f'{base}/{relative}')
            ]
        for relative in missing[:1]:
            yield Reason(f'{relative} is missing in {base}')
        for relative in installed.changed[:_SHOWN_PRODUCTS]:
            text = f'{relative} is not as it was installed in {base}'
            yield Reason(text, is_damage=True)

    def _mode_for_damage(
        self, package: Package, record: Record, differing: Iterable[str]
    ) -> BuildMode:
        kinds = {
            BuildMode.CONFIGURE
            if Path(product).name in CONFIGURED
            else BuildMode.BUILD
            if is_compiled(product, record.products[product])
            else BuildMode.CLEAN
            for product in differing
        }
        if (
            not package.type.endswith('cmake')
            or _generates(record)
            or self._inputs(package).has_commands
        ):
            # what these make of one another is not known
            return BuildMode.CLEAN
        return max(kinds)

    def _built_by_others(
        self, name: str, record: Record, is_changed: bool
    ) -> BuildMode | None:
        """Return how to build what others built; None if it is the same."""
        if self._arguments(name) != record.arguments:
            return BuildMode.REINSTALL
        products = self._products
        installed = products.states(name, record.installed)
        built = products.built(name, installed, record.products)
        if not (
            _are_same(record.installed, installed)
            and _are_same(record.products, built)
        ):
            # unless the source explains it, they had another source
            return BuildMode.BUILD if is_changed else BuildMode.CLEAN
        if is_changed:
            return BuildMode.BUILD
        same = replace(
            record,
            traces=products.traces(name),
            installed=installed,
            products=built,
        )
        self._write(name, same)
        return None

    def _arguments(self, name: str) -> str:
        return text_of(self._products.build(name) / ARGUMENTS)

    def _make_room(
        self, package: Package, mode: BuildMode, known: Record
    ) -> Mapping[Path, Path]:
        products = self._products
        name = package.name
        for folder in (*products.folders(name), products.build(name)):
            remove_dangling(folder, package.path)
        if known.traces == products.traces(name):
            # what others made of it meanwhile; build tools compare times only
            for base, states in (
                (products.build(name), known.products),
                (products.install_base, known.installed),
            ):
                changed = compare(base, states).changed
                products.remove_files(base / path for path in changed)
        if mode >= BuildMode.REINSTALL:
            products.remove_installed(name, known.installed)
        if mode >= BuildMode.CLEAN:
            remove_folder(products.build(name))
        elif mode >= BuildMode.CONFIGURE:
            # what CMake remembers of earlier runs
            (products.build(name) / 'CMakeCache.txt').unlink(missing_ok=True)
            return products.remove_links(name, known.installed)
        return {}


def _mode_for(
    change: Change, package: Package, record: Record, inputs: 'BuildInputs'
) -> BuildMode:
    if package.type.endswith('python'):
        return _mode_for_python(change, record)
    if change.kind is Kind.DELETED and inputs.reads(change.path):
        # what was made from it is still there
        return BuildMode.CLEAN
    name = Path(change.path).name
    is_code = Path(name).suffix.lower() in SOURCE_SUFFIXES
    if change.kind is Kind.NEW and not is_code and inputs.has_header(name):
        # it may come first on the include path
        return BuildMode.CLEAN
    if change.kind is not Kind.CHANGED:
        return BuildMode.CONFIGURE
    if change.mtime <= record.finished:
        # build tools take it for older than what they made of it
        return BuildMode.CLEAN
    if name == 'CMakeLists.txt' or name.endswith('.cmake'):
        # the cache keeps the defaults of options
        return BuildMode.CONFIGURE
    if not inputs.compiles(change.path):
        return BuildMode.CONFIGURE
    return BuildMode.COMPILE if is_code else BuildMode.BUILD


def _mode_for_python(change: Change, record: Record) -> BuildMode:
    is_newer = change.kind is Kind.CHANGED and change.mtime > record.finished
    is_code = change.path not in ('setup.py', 'setup.cfg', 'pyproject.toml')
    # setuptools keeps deleted modules, and compares times
    return BuildMode.BUILD if is_newer and is_code else BuildMode.CLEAN


def _is_apart(
    package: Package,
    record: Record,
    context: BuildContext,
    before: Sequence[Reason],
    own: Collection[str],
) -> bool:
    """Return whether a package need not follow those that it needs."""
    then, now = record.context.dependencies, context.dependencies
    if not package.type.endswith('cmake') or not then.keys() >= {*own}:
        return False
    if not before and all(then[name] == now[name] for name in own):
        # most launches find them as they were
        return False
    from colcon_yamllaunch.workspace.packages.build_files import only_installs

    return only_installs(package.path, own)


def _are_same(
    before: Mapping[str, Fingerprint], now: Mapping[str, Fingerprint]
) -> bool:
    return before.keys() == now.keys() and all(
        is_same(before[name], now[name]) for name in before
    )


def _generates(record: Record) -> bool:
    return any(name.endswith(INTERFACE_SUFFIXES) for name in record.files)


def _of_others(record: Record, found: Iterable[Reason]) -> Iterator[Reason]:
    """Return reasons from beyond a package as they concern its last build."""
    generates = _generates(record)
    for reason in found:
        if generates and reason.mode > BuildMode.COMPILE:
            # rosidl does not compute the hashes of types again when a type
            # of another package that they contain changed
            yield replace(reason, mode=BuildMode.CLEAN)
        else:
            yield reason
