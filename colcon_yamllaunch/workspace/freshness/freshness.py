# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Decides whether a package is up to date.

A package is up to date if a build from scratch would give the same result.
Build tools compare times and cache earlier answers; where this could give
another result, less of the last build is reused. In doubt a package is built.

A package is stale if one of these changed: a file of its source
(`source_changes`); a file elsewhere that its build read, such as a header of
the system (`build_inputs`); a package that it needs (`building.update`); the
environment and arguments of the build (`build_record`); or a file that its
build made (`build_products`).
"""

from collections.abc import (
    Callable,
    Collection,
    Iterable,
    Iterator,
    Mapping,
    Sequence,
)
from contextlib import suppress
from dataclasses import field, replace
import os
from pathlib import Path
import time
from typing import TYPE_CHECKING
import uuid

from colcon_yamllaunch.common.errors import WorkspaceError
from colcon_yamllaunch.common.files import text_of
from colcon_yamllaunch.common.fingerprint import TICK
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.workspace.freshness.build_products import (
    are_same,
    ARGUMENTS,
    compare,
    CONFIGURED,
    former_place,
    is_compiled,
    Products,
    remove_builds,
    remove_folder,
)
from colcon_yamllaunch.workspace.freshness.build_record import (
    build_identifier,
    BuildContext,
    BuildMode,
    changed_variables,
    context_changes,
    DamagedRecordError,
    Decision,
    read_record,
    Reason,
    Record,
    RECORD_NAME,
    searched_variables,
    write_record,
)
from colcon_yamllaunch.workspace.freshness.source_changes import (
    changes,
    INTERFACE_SUFFIXES,
    Kind,
    link_project,
    live_files,
    remove_dangling_links,
    snapshot,
    SOURCE_SUFFIXES,
    SourceChange,
    with_changes,
    with_sources,
)
from colcon_yamllaunch.workspace.packages.package import Package

if TYPE_CHECKING:
    from colcon_yamllaunch.workspace.freshness.build_inputs import BuildInputs

#: What colcon writes for all packages together (colcon-core).
_PREFIX_SCRIPTS = ('setup.sh', 'local_setup.sh', '_local_setup_util_sh.py')
#: How many changed products are listed.
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
    Decides which packages are stale, from the records of their builds.

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
        :param before: Reasons that follow from packages that are built before
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
        if _is_independent(package, record, context, before, own):
            then = {n: record.context.dependencies[n] for n in own}
            context = replace(
                context, dependencies={**context.dependencies, **then}
            )
            before = ()
        reasons = [*self._reasons(package, record, context)]
        if record.built_at:
            reasons += _for_generated_code(record, before)
        return Decision(name, tuple(reasons), record.built_at or None)

    def remove_relocated(
        self, packages: Iterable[Package], announce: Callable[[str], None]
    ) -> None:
        """
        Remove builds that belong to another place.

        :param announce: Is called with a line that says so
        :raises WorkspaceError: when something cannot be removed
        """
        products = self._products
        relocated: dict[str, Path] = {}
        for package in packages:
            name, source = package.name, package.path
            record = self._known_record(name)
            recorded = source if record is None else Path(record.source)
            # the traces of a build name the build folder it was made in
            if record is None or (recorded, record.traces) != (
                source,
                products.traces(name),
            ):
                place = former_place(source, products.build(name), recorded)
                if place is not None:
                    relocated[name] = place
        if not relocated:
            return
        place = next(iter(relocated.values()))
        announce(
            f'the workspace was moved or copied since it was built ({place}): '
            'building anew what belongs to the old place: '
            + ', '.join(relocated)
        )
        remove_builds(relocated, products)
        self._records.clear()

    def prepare(self, package: Package, mode: BuildMode) -> Attempt:
        """
        Prepare a build: remove what it must not find, record the source.

        Links to source files that are gone are removed, as builds fail with
        them. Pass the result to :meth:`record_success` or
        :meth:`record_failure`.

        :param mode: How the package is built
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
        links = self._remove_outdated(package, mode, known)
        if not os.path.exists(self._path(name)):
            # it was removed with the build folder
            self._write(name, record)
        if package.type.endswith('python'):
            link_project(package.path, self._products.build(name))
        started = time.time_ns() - TICK
        with suppress(OSError):
            # by the clock of the build folder
            started = self._path(name).stat().st_mtime_ns
        return Attempt(package, record, started, listed, links)

    def record_success(self, attempt: Attempt, context: BuildContext) -> None:
        """
        Record that a package was built successfully.

        :param context: What the build depended on
        :raises WorkspaceError: when the record that :meth:`prepare` wrote is
          gone
        """
        package, record = attempt.package, attempt.record
        name = package.name
        products = self._products
        if record.mode >= BuildMode.CONFIGURE:
            products.remove_obsolete(name, attempt.listed)
        if not os.path.isfile(self._path(name)):
            # whoever removed the record may have removed more
            raise WorkspaceError(
                f'{self._path(name)} was removed while {name} was built, so '
                'what it was built from is not known',
                'launch again',
            )
        own = [file for file in record.files if not os.path.isabs(file)]
        inputs = self._inputs(package)
        record = self._with_sources(attempt, inputs)
        now = time.time_ns()
        installed = products.states(name, record.installed)
        self._write(
            name,
            replace(
                record,
                succeeded=True,
                finished=now,
                built_at=now,
                live=live_files(
                    package.path,
                    own,
                    products.build(name),
                    [products.install_base / path for path in installed],
                    inputs,
                ),
                installed=installed,
                products=products.built(name, installed, record.products),
                traces=products.traces(name),
                arguments=self._arguments(name),
                variables=searched_variables(
                    inputs.variables(),
                    self._environment,
                    products.install_base,
                ),
                context=context,
            ),
        )

    def record_failure(self, attempt: Attempt) -> None:
        """Record that the build of a package failed or was interrupted."""
        package = attempt.package
        self._products.restore_links(attempt.links)
        record = self._with_sources(attempt, self._inputs(package))
        self._write(package.name, replace(record, finished=time.time_ns()))

    def last_build(self, name: str) -> str | None:
        """Return the last successful build of a package, or None."""
        record = self._known_record(name)
        if record is None or not record.succeeded:
            return None
        return build_identifier(
            record.clean_id, record.interface_id, record.id
        )

    def _with_sources(self, attempt: Attempt, inputs: 'BuildInputs') -> Record:
        path, products = attempt.package.path, self._products
        own = (path, products.build_base, products.install_base)
        read = inputs.external_files(own)
        return with_sources(attempt.record, path, read, attempt.started)

    def _inputs(self, package: Package) -> 'BuildInputs':
        # most launches need not know what builds read
        from colcon_yamllaunch.workspace.freshness.build_inputs import (
            BuildInputs,
        )

        return BuildInputs(package.path, self._products.build(package.name))

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
            yield self._reason_after_failure(package.name, record)
        if record.built_at:
            found = context_changes(record.context, context)
            yield from _for_generated_code(record, found)
            yield from changed_variables(
                record.variables,
                self._environment,
                self._products.install_base,
            )
        edits = changes(package.path, record.files, record.live)
        if edits and record.succeeded and package.type.endswith('cmake'):
            record, edits = self._without_documents(package, record, edits)
        if edits:
            inputs = self._inputs(package)
            for edit in edits:
                mode = _mode_for(edit, package, record, inputs)
                if mode > BuildMode.BUILD and _generates_code(record):
                    mode = BuildMode.CLEAN
                yield Reason(str(edit), mode)
        if record.succeeded:
            yield from self._changed_products(package, record, bool(edits))

    def _without_documents(
        self, package: Package, record: Record, found: tuple[SourceChange, ...]
    ) -> tuple[Record, tuple[SourceChange, ...]]:
        """Leave out changed documents that the build does not read."""
        # most launches find nothing changed
        from colcon_yamllaunch.workspace.packages.build_files import (
            is_document,
            may_be_named,
        )

        documents = [c for c in found if is_document(c.path)]
        if not documents:
            return record, found
        inputs = self._inputs(package)
        unread = [
            c
            for c in documents
            if not inputs.may_use(c.path)
            and not may_be_named(c.path, [record.arguments])
        ]
        if unread:
            files = with_changes(package.path, record.files, unread)
            record = replace(record, files=files)
            # so that it need not be found out again
            self._write(package.name, record)
        return record, tuple(c for c in found if c not in unread)

    def _reason_after_failure(self, name: str, record: Record) -> Reason:
        if not record.finished:
            was_begun = record.traces != self._products.traces(name)
            # a compiler that was killed leaves files that look complete
            mode = BuildMode.CLEAN if was_begun else BuildMode.CONFIGURE
            return Reason(_CUT_OFF, mode)
        if _generates_code(record) and not record.built_at:
            # nothing tells what it was generated from
            return Reason(_FAILED, BuildMode.CLEAN)
        return Reason(
            _FAILED, min(BuildMode(record.mode), BuildMode.CONFIGURE)
        )

    def _changed_products(
        self, package: Package, record: Record, is_edited: bool
    ) -> Iterator[Reason]:
        name = package.name
        if record.traces != self._products.traces(name):
            mode = self._mode_after_other_build(name, record, is_edited)
            if mode is not None:
                yield Reason('something else built it since', mode)
            return
        build, base = self._products.build(name), self._products.install_base
        built = compare(build, record.products)
        installed = compare(base, record.installed)
        if differing := (*built.missing, *built.changed):
            mode = self._mode_for_damage(package, record, differing)
            for product in differing[:_SHOWN_PRODUCTS]:
                is_missing = product in built.missing
                what = 'is missing' if is_missing else 'is not as it was built'
                text = f'{product} {what} in {build}'
                yield Reason(text, mode, is_damage=True)
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
        if (built.touched or installed.touched) and not (
            differing or installed.missing or installed.changed
        ):
            # so that they need not be read again
            now = replace(
                record,
                products={**record.products, **built.touched},
                installed={**record.installed, **installed.touched},
            )
            self._write(name, now)

    def _mode_for_damage(
        self, package: Package, record: Record, differing: Iterable[str]
    ) -> BuildMode:
        if (
            not package.type.endswith('cmake')
            or _generates_code(record)
            or self._inputs(package).has_commands
        ):
            # what these make of one another is not known
            return BuildMode.CLEAN
        return max(
            BuildMode.CONFIGURE
            if os.path.basename(product) in CONFIGURED
            else BuildMode.BUILD
            if is_compiled(product, record.products[product])
            else BuildMode.CLEAN
            for product in differing
        )

    def _mode_after_other_build(
        self, name: str, record: Record, is_changed: bool
    ) -> BuildMode | None:
        """Return how to build after another build; None if nothing changed."""
        if self._arguments(name) != record.arguments:
            return BuildMode.REINSTALL
        if is_changed:
            return BuildMode.BUILD
        products = self._products
        installed = products.states(name, record.installed)
        built = products.built(name, installed, record.products)
        if not (
            are_same(record.installed, installed)
            and are_same(record.products, built)
        ):
            # the source does not explain it: they had another source
            return BuildMode.CLEAN
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

    def _remove_outdated(
        self, package: Package, mode: BuildMode, known: Record
    ) -> Mapping[Path, Path]:
        products = self._products
        name = package.name
        for folder in (*products.folders(name), products.build(name)):
            remove_dangling_links(folder, package.path)
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
    change: SourceChange,
    package: Package,
    record: Record,
    inputs: 'BuildInputs',
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


def _mode_for_python(change: SourceChange, record: Record) -> BuildMode:
    is_newer = change.kind is Kind.CHANGED and change.mtime > record.finished
    is_code = change.path not in ('setup.py', 'setup.cfg', 'pyproject.toml')
    # setuptools keeps deleted modules, and compares times
    return BuildMode.BUILD if is_newer and is_code else BuildMode.CLEAN


def _is_independent(
    package: Package,
    record: Record,
    context: BuildContext,
    before: Sequence[Reason],
    own: Collection[str],
) -> bool:
    """Return whether a build uses no files of the packages it needs."""
    then, now = record.context.dependencies, context.dependencies
    if not package.type.endswith('cmake') or not then.keys() >= {*own}:
        return False
    if not before and all(then[name] == now[name] for name in own):
        # most launches find them as they were
        return False
    from colcon_yamllaunch.workspace.packages.build_files import only_installs

    return only_installs(package.path, own)


def _generates_code(record: Record) -> bool:
    return any(name.endswith(INTERFACE_SUFFIXES) for name in record.files)


def _for_generated_code(
    record: Record, found: Iterable[Reason]
) -> Iterator[Reason]:
    """Return reasons to build; generated code is built from scratch."""
    generates = _generates_code(record)
    for reason in found:
        if generates and reason.mode > BuildMode.COMPILE:
            # rosidl does not compute the hashes of types again when a type
            # of another package that they contain changed
            yield replace(reason, mode=BuildMode.CLEAN)
        else:
            yield reason
