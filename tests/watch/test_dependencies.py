# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What is known of a launch, and what a build changed of it."""

from dataclasses import replace
import os
from pathlib import Path
import subprocess
import sys
from types import SimpleNamespace
from typing import Any, NamedTuple

from colcon_yamllaunch.common.fingerprint import Fingerprint
from colcon_yamllaunch.language.policies.evaluate import Evaluation
from colcon_yamllaunch.language.syntax.source_text import Source
from colcon_yamllaunch.plan.plan import (
    Component,
    ParameterFile,
    Plan,
    Process,
    SetParameter,
)
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.watch import dependencies
from colcon_yamllaunch.watch.consequences import (
    affected_by_build,
    changed_products,
    consequences,
    Steps,
    steps,
)
from colcon_yamllaunch.watch.watched_files import Change
from colcon_yamllaunch.workspace.freshness.build_record import (
    Record,
    RECORD_NAME,
    write_record,
)
from colcon_yamllaunch.workspace.packages.package import Package
from colcon_yamllaunch.workspace.packages.package_locator import PackageLocator
import pytest

HERE = Position('demo.yaml', 1, 1)


def found(digest: str) -> Fingerprint:
    return Fingerprint(1, 1, False, digest)


class FakeWorkspace:
    """A workspace whose builds are written down by hand."""

    def __init__(self, root: Path) -> None:
        self.root: Any = root
        bases = {f'{name}_base': root / name for name in ('build', 'install')}
        self.colcon: Any = SimpleNamespace(root=root, **bases)
        self.packages: list[Package] = []
        self.records: dict[str, Record] = {}

    @property
    def locator(self) -> PackageLocator:
        install = self.colcon.install_base
        return PackageLocator(self.packages, install, False, {})

    def file(self, path: str, text: str = '', mode: int = 0o644) -> str:

        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        file.chmod(mode)
        return str(file)

    def link(self, path: str, target: str) -> str:

        link = self.root / path
        link.parent.mkdir(parents=True, exist_ok=True)
        link.symlink_to(target)
        return str(link)

    def add(self, name: str, *needs: str) -> None:
        """Add a package that was never built."""

        source = self.root / 'src' / name
        source.mkdir(parents=True, exist_ok=True)
        package = Package(name, source, 'ros.ament_cmake', frozenset(needs))
        self.packages.append(package)
        self.records[name] = Record(str(source), {}, succeeded=True)

    def build(self, name: str, *needs: str, **record: Any) -> Record:
        self.add(name, *needs)
        return self.rebuild(name, **record)

    def rebuild(self, name: str, **changes: Any) -> Record:
        record = replace(self.records[name], **changes)
        self.records[name] = record
        folder = self.colcon.build_base / name
        folder.mkdir(parents=True, exist_ok=True)
        write_record(folder / RECORD_NAME, record)
        return record


@pytest.fixture
def workspace(tmp_path: Path) -> FakeWorkspace:
    return FakeWorkspace(tmp_path.resolve())


def process(*argv: str | ParameterFile, **more: Any) -> Process:
    more = {'cwd': '/', 'position': HERE, 'label': 'one', **more}
    return Process(argv=argv, **more)


def evaluation(*files: str, **more: Any) -> Evaluation:
    sources = tuple(Source(file, file, '') for file in files)
    return Evaluation((), sources, {}, (), (), Plan(), **more)


def learn(
    workspace: FakeWorkspace,
    *entries: Process | Component,
    **more: Any,
) -> dependencies.Dependencies:
    return dependencies.find_dependencies(
        Plan(entries),
        evaluation(**more),
        None if workspace.root is None else workspace.colcon,
        workspace.locator,
        [package.name for package in workspace.packages],
        {'PATH': os.environ['PATH']},
    )


def only(known: dependencies.Dependencies) -> dependencies.ProcessDependencies:
    (one,) = known.processes
    return one


def test_linked_script_is_known_by_its_target(
    workspace: FakeWorkspace,
) -> None:
    workspace.build('arm', 'maths')
    workspace.build('maths')
    script = workspace.file('src/arm/scripts/a.py', PYTHON, 0o755)
    program = workspace.link('install/arm/lib/arm/a.py', script)
    one = only(learn(workspace, process(program)))
    assert one.program == script
    assert one.packages == {'arm', 'maths'}
    assert one.may_run_python


def test_compiled_program_runs_no_python(workspace: FakeWorkspace) -> None:
    workspace.build('arm')
    program = workspace.file('build/arm/motor', '\x7fELF…', 0o755)
    link = workspace.link('install/arm/lib/arm/motor', program)
    known = learn(workspace, process('/usr/bin/gdb', '--args', link))
    assert only(known).files == {program}
    assert only(known).packages == {'arm'}
    # what builds make is not watched, as they say themselves what changed
    assert known.files() == ()
    assert not only(learn(workspace, process(link))).may_run_python


def test_files_that_the_plan_names_are_found(workspace: FakeWorkspace) -> None:
    workspace.build('arm')
    names = ['a.rviz', 'b.yaml', 'c.yaml', 'd.conf', 'e.txt', 'f.sh', 'g.py']
    a, b, c, d, e, f, g = (workspace.file(f'src/arm/{n}') for n in names)
    here = str(Path(a).parent)
    given = ParameterFile('', (SetParameter('file', f"'{c}'", HERE),))
    one = process(
        *('bash', '-c', f'{f} --fast && python3 {g}'),
        *('-d', a, '--params-file', 'b.yaml', '-r', '__ns:=/arm'),
        *(f'conf:={d}', '/nowhere/x', '/', here, '\n/'),
        given,
        cwd=here,
        environment=(('FILE', e), ('GONE', None)),
    )
    known = learn(workspace, one)
    # a word that is no path from here names none
    assert only(known).files == {a, c, d, e, f, g}
    one = replace(one, argv=(*one.argv, './b.yaml', f'{here}/late.yaml'))
    known = learn(workspace, one)
    assert only(known).files >= {b, f'{here}/late.yaml'}
    assert set(known.files()) == only(known).files


def test_workspace_below_a_system_folder_is_watched(
    workspace: FakeWorkspace, monkeypatch: pytest.MonkeyPatch
) -> None:
    # as in /opt/my_ws
    system = f'{workspace.root}/'
    monkeypatch.setattr('colcon_yamllaunch.common.files._SYSTEM', (system,))
    workspace.build('arm')
    file = workspace.file('src/arm/a.yaml')
    known = learn(workspace, process('x', file, '/dev/null', '/etc/passwd'))
    assert file in only(known).files
    workspace.root = None
    assert only(learn(workspace, process('x', file))).files == set()


def test_modules_of_a_python_package_are_found(
    workspace: FakeWorkspace,
) -> None:
    # its share folder is linked by way of the build
    build = f'{workspace.root}/build/arm'
    file = 'launch/x.launch.py'
    workspace.build(
        'arm',
        live=frozenset(('arm/__init__.py', 'arm/pose.py', file)),
        installed={f'arm/share/arm/{file}': found(f'link to {build}/{file}')},
    )
    (arm,) = learn(workspace).packages
    assert arm.modules == {'arm/__init__.py', 'arm/pose.py'}
    assert arm.module_folders == {'arm'}


def test_modules_that_programs_import_are_found(
    workspace: FakeWorkspace,
) -> None:
    source = f'{workspace.root}/src/arm'
    workspace.file('src/arm/scripts/a.py', 'import helper\nimport b', 0o755)
    workspace.file('src/arm/scripts/b.py', '', 0o755)
    workspace.file('src/arm/scripts/c.py', '', 0o755)
    workspace.file('src/arm/scripts/helper.py')
    live = (
        *('scripts/a.py', 'scripts/b.py', 'scripts/c.py', 'arm/pose.py'),
        *('scripts/helper.py', 'launch/old.py', 'config/a.yaml'),
    )
    links = {
        'arm/share/arm/launch': 'launch',
        'arm/lib/python3/site-packages/arm': 'arm',
        **{f'arm/lib/{n}': n for n in live if n.startswith('scripts')},
    }
    installed = {
        path.replace('lib/scripts', 'lib/arm'): found(f'link to {source}/{n}')
        for path, n in links.items()
    }
    files = {'x.cpp': found('1'), '/home/me/fast.h': found('1')}
    workspace.build(
        'arm', live=frozenset(live), installed=installed, files=files
    )
    (arm,) = learn(workspace).packages
    assert arm.modules == {'arm/pose.py', 'scripts/b.py', 'scripts/helper.py'}
    assert arm.module_folders == {'arm', 'scripts'}
    assert arm.inputs == {'/home/me/fast.h'}
    assert learn(workspace).folders() == (source,)


def test_container_uses_the_packages_of_its_components(
    workspace: FakeWorkspace,
) -> None:
    workspace.build('arm')
    workspace.build('eye', 'msgs')
    workspace.build('msgs')
    file = workspace.file('src/eye/lens.json')
    box = process('/bin/true', node_name='/box', is_container=True)
    values = (SetParameter('lens', f'"{file}"', HERE),)
    eye = Component('eye', 'eye', 'eye::Eye', '/box', HERE, '', '', (), values)
    other = replace(eye, label='other', container='/elsewhere', parameters=())
    known = learn(workspace, box, eye, other)
    container, component, _ = known.processes
    assert container.packages == component.packages == {'eye', 'msgs'}
    assert component.files == {file}


def test_ros2_launch_may_start_every_package(workspace: FakeWorkspace) -> None:
    workspace.build('arm')
    workspace.build('eye')
    known = learn(workspace, process('ros2', 'run', 'arm', 'motor'))
    assert only(known).packages == {'arm'}
    known = learn(workspace, process('ros2', 'launch', 'x.launch.py'))
    assert only(known).packages == {'arm', 'eye'}


def test_plan_files_are_those_behind_links(
    workspace: FakeWorkspace,
) -> None:
    real = workspace.file('src/arm/launch/demo.yaml')
    link = workspace.link('install/arm/share/arm/launch/demo.yaml', real)
    known = learn(workspace, inputs=(link,), has_run_programs=True)
    assert known.plan_files == {real}
    assert known.files() == (real,)
    assert known.reads_more


def test_without_a_workspace(workspace: FakeWorkspace) -> None:
    workspace.root = None
    script = '/home/nobody/x.sh'
    known = learn(workspace, process(script))
    assert only(known).program == script
    assert known.files() == (script,)


def test_changed_products_are_those_of_a_build(
    workspace: FakeWorkspace,
) -> None:
    build, install = f'{workspace.root}/build', f'{workspace.root}/install'
    products = dict.fromkeys(('motor', 'libarm.so', 'x.o'), found('1'))
    installed = {'arm/share/arm/a.yaml': found('1')}
    workspace.build('arm', installed=installed, products=products)
    before = dependencies.build_products(workspace.colcon, ['arm'])
    assert changed_products(before, before) == {}
    products = {**products, 'libarm.so': found('2'), 'new': found('1')}
    workspace.rebuild('arm', installed={}, products=products)
    after = dependencies.build_products(workspace.colcon, ['arm'])
    changed = changed_products(before, after)
    names = f'{build}/arm/libarm.so', f'{build}/arm/new'
    files = (*names, f'{install}/arm/share/arm/a.yaml')
    assert changed == dict.fromkeys(files, 'arm')
    # one that was never built
    assert changed_products({}, after).keys() == after['arm'].keys()
    # times tell nothing
    workspace.rebuild('arm', built_at=9)
    again = dependencies.build_products(workspace.colcon, ['arm'])
    assert changed_products(after, again) == {}


ARM = frozenset(('arm',))
MOTOR = '/ws/build/arm/motor'
MODULE = '/ws/install/arm/lib/python3.11/site-packages/arm/pose.py'
OF_ARM: dict[str, Any] = {'packages': ARM}
PYTHON_OF_ARM = {**OF_ARM, 'may_run_python': True}


@pytest.mark.parametrize(
    ('use', 'path', 'is_affected'),
    [
        ({'program': MOTOR}, MOTOR, True),
        ({'program': '/ws/build/arm/other'}, MOTOR, False),
        ({'files': frozenset(('/ws/a.yaml',))}, '/ws/a.yaml', True),
        # a library: as it is mapped, or may have been
        ({**OF_ARM, 'libraries': {'/l.so.1'}}, '/l.so.1', True),
        ({**OF_ARM, 'libraries': set()}, '/l.so', False),
        (OF_ARM, '/l.so', True),
        ({}, '/l.so', False),
        ({**OF_ARM, 'is_component': True}, '/l.so', False),
        # a module
        (PYTHON_OF_ARM, MODULE, True),
        (OF_ARM, MODULE, False),
        ({**OF_ARM, 'libraries': {'/usr/lib/libpython3.so'}}, MODULE, True),
        ({'may_run_python': True}, MODULE, False),
        # no module
        (PYTHON_OF_ARM, '/ws/install/arm/share/arm/launch/x.py', False),
        (PYTHON_OF_ARM, '/ws/install/arm/lib/arm/x.py', False),
    ],
)
def test_build_affects_the_processes_that_use_its_products(
    use: dict[str, Any], path: str, is_affected: bool
) -> None:
    use = dict(use)
    mapped = {'x': use.pop('libraries')} if 'libraries' in use else {}
    known = dependencies.Dependencies(
        (dependencies.ProcessDependencies('x', **use),)
    )
    assert bool(affected_by_build({path: 'arm'}, known, mapped)) == is_affected
    assert affected_by_build({}, known, mapped) == {}


def test_files_mapped_into_a_process_are_found() -> None:
    code = 'import time; print(flush=True); time.sleep(60)'
    with subprocess.Popen(
        # what a shell starts counts as well
        ['/bin/sh', '-c', f"'{sys.executable}' -c '{code}'; exit"],
        stdout=subprocess.PIPE,
        start_new_session=True,
    ) as shell:
        assert shell.stdout is not None
        shell.stdout.readline()
        found = dependencies.mapped_files(shell.pid)
        os.killpg(shell.pid, 9)
    python = os.path.realpath(sys.executable)
    assert found is not None
    assert python.startswith('/usr/') or python in found
    # what has ended maps nothing
    assert dependencies.mapped_files(shell.pid) is None


class Kind(NamedTuple):
    """
    A kind of file in the package `arm`, and the process that uses it.

    :param source: The file that is saved
    :param program: The program of the process, in the install space
    :param code: How that begins
    :param built: What differs on a machine once it has the change, in the
      install space
    :param is_live: Whether it is linked into the install space here
    """

    source: str
    program: str
    code: str
    built: str
    is_live: bool = True


LAUNCH = 'launch/demo.yaml'
ELF, PYTHON = '\x7fELF', '#!/usr/bin/python3\n'
TALK = 'lib/arm/talk'
KINDS = {
    'script': Kind('scripts/talk.py', f'{TALK}.py', PYTHON, f'{TALK}.py'),
    'library': Kind('src/word.cpp', TALK, ELF, 'lib/libword.so', False),
    'C++ program': Kind('src/talk.cpp', TALK, ELF, TALK, False),
    'Python module': Kind(
        *('arm/word.py', 'lib/arm/run', PYTHON),
        'lib/python3.12/site-packages/arm/word.py',
    ),
    'configuration': Kind(
        'config/c.yaml', TALK, ELF, 'share/arm/config/c.yaml'
    ),
    'launch file': Kind(LAUNCH, TALK, ELF, 'share/arm/' + LAUNCH),
}


@pytest.mark.parametrize('kind', KINDS.values(), ids=KINDS)
@pytest.mark.parametrize('sync', ['build', 'none'])
@pytest.mark.parametrize('is_installed', [True, False])
def test_only_changes_on_the_machine_restart_its_processes(
    workspace: FakeWorkspace, kind: Kind, sync: str, is_installed: bool
) -> None:
    label = 'arm│talk'
    source = workspace.file(f'src/arm/{kind.source}', kind.code, 0o755)
    install = f'{workspace.root}/install/arm'
    links = {}
    if is_installed:
        workspace.file(f'install/arm/{kind.program}', kind.code, 0o755)
    if is_installed and kind.is_live:
        Path(install, kind.built).unlink(missing_ok=True)
        workspace.link(f'install/arm/{kind.built}', source)
        links = {f'arm/{kind.built}': found(f'link to {source}')}
    workspace.add('arm')
    if is_installed:
        live = frozenset({kind.source} if kind.is_live else ())
        workspace.rebuild('arm', live=live, installed=links)
    files = (f'{install}/{kind.program}', f'{install}/share/arm/config/c.yaml')
    known = dependencies.find_dependencies(
        Plan((process(*files, label=label, package='arm'),)),
        evaluation(f'{workspace.root}/src/arm/{LAUNCH}'),
        *(workspace.colcon, workspace.locator),
        *(['arm'] if is_installed else [], {}),
        dependencies.RemoteDependencies(
            {label: 'arm'},
            {label: frozenset(files)},
            {'arm': ARM},
            {'arm': 'sync: none'} if sync == 'none' else {},
        ),
    )
    change = Change('changed', source, source)
    needed = steps(consequences([change], known), known)
    # nothing is restarted before the machine has the change
    assert needed.restart == needed.after_build == ()
    is_launch = kind.source == LAUNCH
    assert needed.replan == is_launch
    if sync == 'none':
        assert needed.kept == (() if is_launch else ('arm (sync: none)',))
    else:
        assert (needed.build, needed.kept) == ({'arm'}, ())
    # what is built here is not there; the plan shows the effects of another
    # launch file
    expected = set() if is_launch else {label}
    for place, affected in (('', set()), ('arm│', expected), ('gpu│', set())):
        changed = {f'{place}{install}/{kind.built}': 'arm'}
        assert affected_by_build(changed, known, {}).keys() == affected


def test_file_of_no_package_is_compared_on_the_machine() -> None:
    path = '/home/me/a.yaml'
    files = {'arm│talk': frozenset((path,))}
    known = dependencies.Dependencies(
        remote=dependencies.RemoteDependencies(files=files)
    )
    assert known.files() == (path,)
    change = Change('changed', path, path)
    assert steps(consequences([change], known), known) == Steps(replan=True)
