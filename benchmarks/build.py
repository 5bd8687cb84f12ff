#!/usr/bin/env python3
# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Time `colcon launch` beside the commands that it stands for.

usage: python benchmarks/build.py [--runs N] [--keep FOLDER] [NAME ...]

It measures the `colcon` that is first on the PATH. In a clone with a virtual
environment in `.venv`, which for `ament` needs the extra `ros`:

    PATH=$PWD/.venv/bin:$PATH python benchmarks/build.py all

An editable installation starts some milliseconds later than an installed
one, and one that was never compiled much later: unset PYTHONDONTWRITEBYTECODE.

Each workspace is made and built once; then, in turns, with nothing changed,
the seconds are measured from the start of a command until the first process of
the launch prints the time: of `colcon build` and `source install/setup.bash`,
for all packages and for the needed ones, and of `colcon launch`. Where there
is a `ros2`, the first two go on with `ros2 launch`; else their process is
started by the shell. `after` is the first launch after those, which looks at
what they wrote anew and sources it, `launch` the one after that. Printed are
medians, and of `colcon launch` also the processor time, which a busy machine
changes less. The floor, in the same turns, is what `colcon --help` without our
verb and `source install/setup.bash` take. `edit` compares a launch after one
changed C++ file with `cmake --build` and `cmake --install` alone, `import` is
what our verb costs every other colcon command.

names: one, cmake, edit, import (the default), ament, python, thousand,
environment, all; `ament`, `python` and `thousand` take a minute or more to be
built, `python` several.

`environment` needs the extra `ros`, too. It compares launches that source the
workspace with those that remember what that made: with packages of ament_cmake
of which ten are built and the others installed like them, each also in a shell
where an underlay of 300 such packages is sourced, which setup.bash chains.
"""

import argparse
from collections.abc import Callable, Iterator
from dataclasses import dataclass
import os
from pathlib import Path
import re
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

QUICK = ('one', 'cmake', 'edit', 'import')
#: How often a command is run that takes longer than a few seconds (seconds).
LONG_RUN = 8.0
LONG_RUNS = 2
#: How many packages there are where sourcing is measured.
OVERLAYS = (1, 100, 400)
UNDERLAY = 300
#: What colcon shall not do while its start is measured.
BLOCKED = {'COLCON_EXTENSION_BLOCKLIST': 'colcon_core.verb.launch'}

_STAMP = re.compile(r'\b\d{10}\.\d{9}\b')
LAUNCH = "launch: [executable: {cmd: 'date +%s.%N'}]\n"
MANIFEST = """\
<package format="3"><name>{name}</name><version>0.1.0</version>
<description>x</description><license>Apache-2.0</license>
<maintainer email="x@example.com">x</maintainer>{depends}
<export><build_type>{build_type}</build_type></export></package>
"""
CMAKE = """\
cmake_minimum_required(VERSION 3.16)
project({name} {languages})
{code}
install(DIRECTORY launch DESTINATION share/{name})
"""
AMENT = CMAKE + 'ament_package()\n'
CPP = """\
add_executable(flow src/flow.cpp)
install(TARGETS flow DESTINATION lib/flow)
"""
SETUP = """\
from setuptools import setup
setup(name='{name}', version='0.1.0', packages=['{name}'], data_files=[
    ('share/ament_index/resource_index/packages', ['resource/{name}']),
    ('share/{name}', ['package.xml']),
    ('share/{name}/launch', ['launch/demo.yaml'])])
"""
#: Both are started in one way: colcon is asked anew by another sys.path.
CACHED = """\
import sys
from colcon_core.command import main
sys.exit(main())
"""
SOURCING = """\
import sys
from colcon_core.command import main
from colcon_yamllaunch.workspace.environment import environment_cache
from colcon_yamllaunch.workspace.environment.sourcing import source
environment_cache.cached_environment = lambda setup, variables, _: source(
    setup, variables)
sys.exit(main())
"""
IMPORT = """\
import time, argparse, colcon_core.command, colcon_core.verb
start = time.perf_counter()
import colcon_yamllaunch.verb.launch
print(time.perf_counter() - start)
"""


@dataclass(frozen=True)
class Case:
    """
    A workspace to be measured.

    :param title: What it is called in the table
    :param kind: What its packages are: cmake, ament or python
    :param count: How many there are
    :param needed: How many the launch needs
    :param allowed: What a launch may take (seconds)
    :param guide: Whether the other commands are measured, too
    """

    title: str
    kind: str
    count: int
    needed: int
    allowed: float
    guide: bool = True


CASES = {
    'one': Case('1 CMake package', 'cmake', 1, 1, 0.22),
    'cmake': Case('100 CMake packages', 'cmake', 100, 1, 0.25),
    'ament': Case('100 ament_cmake, 10 needed', 'ament', 100, 10, 0.28),
    'python': Case('100 ament_python', 'python', 100, 1, 0.28),
    'thousand': Case('1,000 CMake, 20 needed', 'cmake', 1000, 20, 0.45, False),
}


def main() -> None:
    """Run the benchmarks that are asked for."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    names = (*CASES, 'edit', 'import', 'environment', 'all')
    parser.add_argument('names', nargs='*', metavar='NAME', default=QUICK)
    parser.add_argument('--runs', type=int, default=9)
    parser.add_argument('--keep', metavar='FOLDER', type=Path)
    options = parser.parse_args()
    unknown = set(options.names) - set(names)
    if unknown:
        parser.error(f'no such name: {", ".join(sorted(unknown))}')
    chosen = names[:-1] if 'all' in options.names else options.names
    with tempfile.TemporaryDirectory(prefix='benchmark-') as temporary:
        folder = options.keep or Path(temporary)
        for line in report(folder.absolute(), chosen, options.runs):
            print(line, flush=True)


def report(folder: Path, names: 'list[str]', runs: int) -> Iterator[str]:
    """Measure, and return the lines of the report."""
    colcon = shutil.which('colcon')
    if colcon is None:
        sys.exit('there is no colcon on the PATH')
    load = os.getloadavg()[0]
    yield f'{colcon}, {os.cpu_count()} cores, load {load:.1f}, seconds:'
    cases = [name for name in CASES if name in names]
    if cases:
        third = ' + ros2 launch' if shutil.which('ros2') else ''
        yield f'(build = colcon build --symlink-install + source{third})'
        yield (
            f'{"workspace":<28}{"build all":>10}{"selected":>10}'
            f'{"after":>9}{"launch":>9}{"allowed":>9}{"CPU":>7}'
            f'{"colcon":>8}{"source":>8}'
        )
    for name in cases:
        yield measure(folder / name, CASES[name], runs)
    if 'edit' in names:
        yield from measure_edit(folder / 'edit', runs)
    if 'import' in names:
        yield from measure_import(folder / 'import', runs)
    if 'environment' in names:
        yield from measure_environment(folder / 'environment', runs)


def measure(root: Path, case: Case, runs: int) -> str:
    """Measure one workspace, and return a row of the table."""
    make(root, case)
    needed = [package(number) for number in range(case.needed)]
    source = 'source install/setup.bash && date +%s.%N'
    if shutil.which('ros2'):
        source = source.replace('date +%s.%N', f'ros2 launch {needed[0]} demo')
    build = 'colcon build --symlink-install'
    selected = f'{build} --packages-select {" ".join(needed)}'
    command = ['colcon', 'launch', needed[0], 'demo.yaml']
    guide = [
        ['bash', '-c', f'{built} && {source}']
        for built in (build, selected)
        if case.guide
    ]
    if guide:
        run(root, build)
    run(root, ' '.join(command))
    sourcing = ['bash', '-c', 'source install/setup.bash']
    start, alone, *builds, after, launch = in_turns(
        [
            timed(root, 'colcon --help', BLOCKED),
            timed(root, sourcing),
            *(stamped(root, built) for built in [*guide, command, command]),
        ],
        runs,
    )
    (processor,) = in_turns([processor_time(root, command)], runs)
    columns = [f'{seconds:>10.2f}' for seconds in builds]
    columns += [f'{after:>9.3f}'] if guide else [f'{"-":>10}'] * 2 + [' ' * 9]
    return (
        f'{case.title:<28}{"".join(columns)}{launch:>9.3f}'
        f'{case.allowed:>9.2f}{processor:>7.3f}{start:>8.3f}{alone:>8.3f}'
    )


def measure_edit(root: Path, runs: int) -> Iterator[str]:
    """Measure what a launch adds to the build of one changed file."""
    make(root, Case('', 'cmake', 99, 0, 0))
    folder = root / 'src/flow'
    write(
        folder / 'CMakeLists.txt',
        CMAKE.format(name='flow', languages='CXX', code=CPP),
    )
    write(folder / 'launch/demo.yaml', LAUNCH)
    write(folder / 'src/flow.cpp', 'int main() {}\n')
    command = ['colcon', 'launch', 'flow', 'demo.yaml']
    run(root, ' '.join(command))
    count = iter(range(1_000_000))

    def edit() -> None:
        text = f'int main() {{ return {next(count)} & 0; }}\n'
        write(folder / 'src/flow.cpp', text)

    def alone() -> float:
        edit()
        started = time.time()
        for action in ('--build', '--install'):
            run(root, f'cmake {action} build/flow')
        return time.time() - started

    launched = stamped(root, command)

    def changed() -> float:
        edit()
        return launched()

    bare, whole, same = in_turns([alone, changed, launched], runs)
    yield f'one changed C++ file, one of 100 packages: launch {whole:.3f}'
    yield f'  cmake --build and --install alone: {bare:.3f}'
    yield f'  more than those: {whole - bare:.3f} (allowed: 0.150)'
    yield f'  launch with nothing changed: {same:.3f}'
    yield f'  more than that and those: {whole - same - bare:.3f}'


def measure_import(root: Path, runs: int) -> Iterator[str]:
    """Measure what the verb costs every colcon command."""
    make(root, Case('', 'cmake', 1, 0, 0))

    def imported() -> float:
        return float(run(root, [sys.executable, '-c', IMPORT]))

    helped = [timed(root, 'colcon --help', v) for v in ({}, BLOCKED)]
    ours, others = in_turns(helped, 3 * runs)
    (alone,) = in_turns([imported], runs)
    yield f'colcon --help: {ours:.3f}, without the verb {others:.3f}'
    yield f'  importing the verb: {alone * 1000:.2f} ms (allowed: 2 ms)'


def measure_environment(folder: Path, runs: int) -> Iterator[str]:
    """Measure launches that source and those that need not."""
    below = folder / 'underlay'
    install(below, UNDERLAY, {}, 'below')
    sourced = run(below, ['bash', '-c', '. install/setup.bash; env -0'])
    entries = (e.partition('=') for e in sourced.split('\0') if e)
    shell = {name: value for name, _, value in entries}
    yield (
        f'{"ament_cmake packages":<28}{"source":>8}{"sourced":>9}'
        f'{"remembered":>12}{"saved":>8}{"CPU saved":>11}'
    )
    for count in OVERLAYS:
        for variables in ({}, shell):
            title = f'{count}, underlay of {UNDERLAY}' if variables else count
            root = folder / f'{count}{"_chained" * bool(variables)}'
            install(root, count, variables)
            launch = ['launch', package(0), 'demo.yaml']
            fast = [sys.executable, '-c', CACHED, *launch]
            slow = [sys.executable, '-c', SOURCING, *launch]
            run(root, fast, variables)
            sourcing = ['bash', '-c', 'source install/setup.bash']
            alone, long, short, *processor = in_turns(
                [
                    timed(root, sourcing, variables),
                    stamped(root, slow, variables),
                    stamped(root, fast, variables),
                    processor_time(root, slow, variables),
                    processor_time(root, fast, variables),
                ],
                runs,
            )
            yield (
                f'{title:<28}{alone:>8.3f}{long:>9.3f}{short:>12.3f}'
                f'{long - short:>8.3f}{processor[0] - processor[1]:>11.3f}'
            )


def install(
    root: Path, count: int, variables: 'dict[str, str]', prefix: str = 'pkg'
) -> None:
    """Build some packages of ament_cmake, and install others like one."""
    if root.exists():
        return
    built = min(count, 10)
    make(root, Case('', 'ament', built, built, 0))
    run(root, ['colcon', 'launch', package(0), 'demo.yaml'], variables)
    names = [f'{prefix}_{number:03}' for number in range(count)]
    model = root / 'install' / package(built - 1)
    for name in names:
        for path in model.rglob('*'):
            copy = Path(str(path).replace(model.name, name))
            if path.is_file() and not copy.exists():
                write(copy, path.read_text().replace(model.name, name))
    for folder in (root / 'install').glob('pkg_*'):
        if folder.name not in names:
            shutil.rmtree(folder)


def timed(
    root: Path,
    command: 'str | list[str]',
    variables: 'dict[str, str] | None' = None,
) -> Callable[[], float]:
    """Return what measures how long a command takes."""

    def once() -> float:
        started = time.time()
        run(root, command, variables)
        return time.time() - started

    return once


def stamped(
    root: Path,
    command: 'list[str]',
    variables: 'dict[str, str] | None' = None,
) -> Callable[[], float]:
    """Return what measures the time until a process prints the time."""

    def once() -> float:
        started = time.time()
        output = run(root, command, variables)
        match = _STAMP.search(output)
        if match is None:
            sys.exit(f'{" ".join(command)} printed no time: {output}')
        return float(match[0]) - started

    return once


def processor_time(
    root: Path,
    command: 'list[str]',
    variables: 'dict[str, str] | None' = None,
) -> Callable[[], float]:
    """Return what measures the processor time of a command."""

    def spent() -> float:
        usage = resource.getrusage(resource.RUSAGE_CHILDREN)
        return usage.ru_utime + usage.ru_stime

    def once() -> float:
        before = spent()
        run(root, command, variables)
        return spent() - before

    return once


def in_turns(
    measured: 'list[Callable[[], float]]', runs: int
) -> 'list[float]':
    """Return the median of each, none of them in quieter times than others."""
    times: list[list[float]] = [[] for _ in measured]
    for _ in range(runs):
        for once, results in zip(measured, times, strict=True):
            is_long = bool(results) and results[0] > LONG_RUN
            if not is_long or len(results) < LONG_RUNS:
                results.append(once())
    return [statistics.median(results) for results in times]


def run(
    root: Path,
    command: 'str | list[str]',
    variables: 'dict[str, str] | None' = None,
) -> str:
    """Run a command to its end, and return what it printed."""
    done = subprocess.run(
        command.split() if isinstance(command, str) else command,
        cwd=root,
        env=os.environ | (variables or {}),
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
    )
    if done.returncode:
        sys.exit(f'{command} failed:\n{done.stdout}{done.stderr}')
    return done.stdout


def make(root: Path, case: Case) -> None:
    """Write a workspace, unless it was kept."""
    if root.exists():
        return
    print(f'making {root} …', file=sys.stderr)
    makers = {'cmake': cmake, 'ament': ament, 'python': python}
    for number in range(case.count):
        folder = root / 'src' / package(number)
        # the first one needs the next ones, each on its own
        needs = range(1, case.needed) if number == 0 else ()
        depends = ''.join(
            f'<exec_depend>{package(other)}</exec_depend>' for other in needs
        )
        write(folder / 'launch/demo.yaml', LAUNCH)
        makers[case.kind](folder, depends)


def package(number: int) -> str:
    """Return the name of a package."""
    return f'pkg_{number:03}'


def cmake(folder: Path, depends: str) -> None:
    """Write a package of plain CMake."""
    name = folder.name
    text = CMAKE.format(name=name, languages='NONE', code='')
    write(folder / 'CMakeLists.txt', text)
    write_manifest(folder, 'cmake', depends)


def ament(folder: Path, depends: str) -> None:
    """Write a package of ament_cmake."""
    find = 'find_package(ament_cmake REQUIRED)'
    name = folder.name
    text = AMENT.format(name=name, languages='NONE', code=find)
    write(folder / 'CMakeLists.txt', text)
    depends = f'<buildtool_depend>ament_cmake</buildtool_depend>{depends}'
    write_manifest(folder, 'ament_cmake', depends)


def python(folder: Path, depends: str) -> None:
    """Write a package of ament_python."""
    name = folder.name
    write(folder / 'setup.py', SETUP.format(name=name))
    write(folder / 'resource' / name, '')
    write(folder / name / '__init__.py', '')
    write_manifest(folder, 'ament_python', depends)


def write_manifest(folder: Path, build_type: str, depends: str) -> None:
    """Write a package.xml."""
    text = MANIFEST.format(
        name=folder.name, build_type=build_type, depends=depends
    )
    write(folder / 'package.xml', text)


def write(path: Path, text: str) -> None:
    """Write a file, and the folders that it is in."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding='utf-8')


if __name__ == '__main__':
    main()
