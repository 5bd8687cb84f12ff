# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Random edits, each followed by a launch, measured against a clean build.

After each launch the install space must be what a build from scratch gives.
Builds that changed nothing are counted: `pytest --hypothesis-show-statistics`
shows them, and so does `pytest -rP` in one line at the end of each test.
"""

from collections import Counter
from collections.abc import Iterator
import json
import os
from pathlib import Path
import shutil
import subprocess
import time

from hypothesis import event, example, given, HealthCheck, settings
from hypothesis import strategies as st
import pytest
from support.manifest import manifest

LOOP = """\
for line in sys.stdin:
    root, arguments, variables = json.loads(line)
    os.chdir(root)
    os.environ.update(variables)
    colcon = CachedColcon(Path(root), arguments)
    result = bring_up_to_date(colcon, ['top'], dict(os.environ), print)
    for name in variables:
        del os.environ[name]
    show([result.returncode, dict(result.stale)])
    sys.stdout.flush()
"""
PACKAGES = ('base', 'mid', 'top')
BASE = """\
cmake_minimum_required(VERSION 3.16)
project(base NONE)
set(MODE 1 CACHE STRING "Which one")
configure_file(value.txt.in value.txt)
install(FILES ${CMAKE_BINARY_DIR}/value.txt DESTINATION share/base)
install(DIRECTORY include DESTINATION .)
install(FILES baseConfig.cmake DESTINATION share/base/cmake)
"""
MID = """\
cmake_minimum_required(VERSION 3.16)
project(mid NONE)
find_package(base REQUIRED)
file(READ ${base_PREFIX}/share/base/value.txt value)
file(READ table.csv table)
file(GLOB names RELATIVE ${CMAKE_SOURCE_DIR} data/*)
file(WRITE ${CMAKE_BINARY_DIR}/all.txt "${value} ${table} ${names}")
install(FILES ${CMAKE_BINARY_DIR}/all.txt table.csv DESTINATION share/mid)
install(DIRECTORY data DESTINATION share/mid USE_SOURCE_PERMISSIONS)
"""
TOP = """\
cmake_minimum_required(VERSION 3.16)
project(top C)
find_package(base REQUIRED)
file(GLOB sources src/*.c)
add_executable(top ${sources})
target_include_directories(top PRIVATE ${base_PREFIX}/include)
install(TARGETS top DESTINATION lib/top)
install(DIRECTORY launch DESTINATION share/top)
install(PROGRAMS scripts/run.py DESTINATION lib/top)
"""
FILES = {
    'base/CMakeLists.txt': BASE,
    'base/baseConfig.cmake': (
        'get_filename_component(\n'
        '  base_PREFIX "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)\n'
    ),
    'base/value.txt.in': '@MODE@ 1\n',
    'base/include/base.h': '#define BASE 1\n',
    'mid/CMakeLists.txt': MID,
    'mid/table.csv': '1\n',
    'mid/data/one': '1\n',
    'top/CMakeLists.txt': TOP,
    'top/src/main.c': (
        '#include <stdio.h>\n#include "base.h"\n#include "own.h"\n'
        'int main(void) { return printf("%d %d\\n", BASE, OWN) < 0; }\n'
    ),
    'top/src/own.h': '#define OWN 1\n',
    'top/launch/top.yaml': 'launch: []\n',
    'top/scripts/run.py': '#!/usr/bin/env python3\n',
}
#: Where a number is put in to make another content.
SPOTS = {
    'base/CMakeLists.txt': 'MODE 1',
    'base/baseConfig.cmake': (
        'get_filename_component(\n'
        '  base_PREFIX "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)\n'
    ),
    'base/value.txt.in': ' 1',
    'base/include/base.h': 'BASE 1',
    'mid/table.csv': '1',
    'mid/data/one': '1',
    'top/src/own.h': 'OWN 1',
}
NEW = (
    *('mid/data/two', 'top/launch/two.yaml', 'top/src/two.c', 'base/x.md'),
    *('mid/README.md', 'top/guide.md'),
)
REMOVABLE = (*NEW, 'mid/data/one', 'top/launch/top.yaml', 'mid/table.csv')
HOUR = 3600.0

files = st.sampled_from(sorted(FILES))
edits = st.one_of(
    st.tuples(
        st.just('edit'),
        st.sampled_from(sorted(SPOTS)),
        st.integers(1, 3),
        st.sampled_from((0.0, 0.0, -HOUR, HOUR)),
    ),
    st.tuples(st.just('touch'), files, st.sampled_from((0.0, -HOUR, HOUR))),
    st.tuples(st.just('add'), st.sampled_from(NEW)),
    st.tuples(st.just('delete'), st.sampled_from(REMOVABLE)),
    st.tuples(
        st.just('rename'), st.sampled_from(REMOVABLE), st.sampled_from(NEW)
    ),
    st.tuples(st.just('chmod'), files),
    st.tuples(st.just('checkout'), st.sampled_from(('one', 'two'))),
    st.tuples(st.just('arguments'), st.integers(1, 2)),
    st.tuples(st.just('flags'), st.sampled_from(('', '-DX=1'))),
    st.tuples(
        st.just('remove'),
        st.sampled_from(('build', 'install')),
        st.sampled_from(('', *PACKAGES)),
    ),
    st.tuples(st.just('damage'), st.sampled_from(PACKAGES)),
    st.tuples(st.just('colcon build'), st.booleans()),
)
#: Between two launches there may be several.
launches = st.lists(st.lists(edits, max_size=3), min_size=1, max_size=4)


class Laboratory:
    """A workspace that is edited, and launches in it."""

    def __init__(self, workspace, process) -> None:
        self.root = workspace.root
        self.source = workspace.root / 'src'
        self.template = workspace.root.with_name('template')
        self.clean = workspace.root.with_name('clean')
        self.workspace = workspace
        self.process = process
        self.counts = Counter()
        self.arguments: list[str] = []
        self.variables: dict[str, str] = {}

    def make(self) -> None:
        """Write the workspace, in two commits, and build it."""
        for path, text in FILES.items():
            mode = 0o755 if path.endswith('.py') else 0o644
            self.workspace.write(f'src/{path}', text, mode)
        needs = {'mid': 'base', 'top': 'base'}
        for name in PACKAGES:
            depends = ''
            if name in needs:
                depends = f'<depend>{needs[name]}</depend>'
            if name == 'top':
                depends += '<exec_depend>mid</exec_depend>'
            text = manifest(name, 'cmake', depends)
            self.workspace.write(f'src/{name}/package.xml', text)
        self.git('init', '-q')
        self.commit('one')
        for path, spot in SPOTS.items():
            file = self.source / path
            other = spot.replace('1', '7')
            file.write_text(file.read_text().replace(spot, other))
        (self.source / 'top/src/two.c').write_text('int two = 2;\n')
        self.commit('two')
        self.checkout('one')
        assert self.launch() == (0, dict.fromkeys(PACKAGES, 'never built'))
        shutil.copytree(self.root, self.template, symlinks=True)

    def reset(self) -> None:
        """Begin anew; the copy has the same path and the same times."""
        shutil.rmtree(self.root)
        shutil.copytree(self.template, self.root, symlinks=True)
        self.arguments, self.variables = [], {}

    def git(self, *words: str) -> None:
        user = ['-c', 'user.name=x', '-c', 'user.email=x@example.com']
        subprocess.run(['git', *user, *words], cwd=self.source, check=True)

    def commit(self, tag: str) -> None:
        self.git('add', '-A')
        self.git('commit', '-q', '-m', tag)
        self.git('tag', tag)

    def checkout(self, tag: str) -> None:
        self.git('checkout', '-q', '-f', tag)
        self.git('clean', '-q', '-f', '-d')

    def apply(self, edit: tuple) -> None:
        """Do what a user might do between two launches."""
        kind, *rest = edit
        if kind == 'edit':
            path, number, later = rest
            file = self.source / path
            if file.exists():
                spot = SPOTS[path]
                text = FILES[path].replace(spot, spot[:-1] + str(number))
                file.write_text(text)
                set_time(file, later)
        elif kind == 'touch':
            file = self.source / rest[0]
            if file.exists():
                set_time(file, rest[1])
        elif kind == 'add':
            (self.source / rest[0]).write_text('')
        elif kind == 'delete':
            (self.source / rest[0]).unlink(missing_ok=True)
        elif kind == 'rename':
            if (self.source / rest[0]).exists():
                (self.source / rest[0]).rename(self.source / rest[1])
        elif kind == 'chmod':
            file = self.source / rest[0]
            if file.exists():
                file.chmod(file.stat().st_mode ^ 0o100)
        elif kind == 'checkout':
            self.checkout(rest[0])
        else:
            self.disturb(kind, *rest)

    def disturb(self, kind: str, *rest) -> None:
        """Do what concerns no source file."""
        if kind == 'arguments':
            self.arguments = ['--cmake-args', f'-DMODE={rest[0]}']
        elif kind == 'flags':
            self.variables = {'CFLAGS': rest[0]} if rest[0] else {}
        elif kind == 'remove':
            shutil.rmtree(self.root.joinpath(*rest), ignore_errors=True)
        elif kind == 'damage':
            record = self.root / 'build' / rest[0] / 'colcon_launch.json'
            if record.exists():
                record.write_text('{')
        elif kind == 'colcon build':
            symlink = ['--symlink-install'] if rest[0] else []
            subprocess.run(
                ['colcon', '--log-base', os.devnull, 'build', *symlink],
                cwd=self.root,
                env=self.workspace.environment(),
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
            )

    def launch(self) -> tuple[int, dict[str, str]]:
        """Bring up to date what the launch needs."""
        request = [str(self.root), self.arguments, self.variables]
        print(json.dumps(request), file=self.process.stdin, flush=True)
        output = ''
        for line in self.process.stdout:
            if line.startswith('RESULT '):
                returncode, stale = json.loads(line.removeprefix('RESULT '))
                return returncode, stale
            output += line
        raise AssertionError(output)

    def clean_build(self) -> dict[str, dict[str, str]] | None:
        """Build from scratch elsewhere; None if that fails."""
        shutil.rmtree(self.clean, ignore_errors=True)
        prefixes = [self.clean / 'install' / name for name in PACKAGES]
        environment = self.workspace.environment(
            CMAKE_PREFIX_PATH=os.pathsep.join(map(str, prefixes)),
            CMAKE_INSTALL_MODE='ABS_SYMLINK_OR_COPY',
            **self.variables,
        )
        for name, prefix in zip(PACKAGES, prefixes, strict=True):
            build = self.clean / 'build' / name
            defined = [a for a in self.arguments if a.startswith('-D')]
            configure = ['-S', self.source / name, '-B', build, *defined]
            for words in (
                [*configure, f'-DCMAKE_INSTALL_PREFIX={prefix}'],
                ['--build', build],
                ['--install', build],
            ):
                done = subprocess.run(
                    ['cmake', *words], env=environment, capture_output=True
                )
                if done.returncode:
                    return None
        return contents(self.clean / 'install')

    def launch_and_compare(self) -> None:
        """Launch, and compare the outcome with that of a clean build."""
        before = contents(self.root / 'install')
        returncode, stale = self.launch()
        expected = self.clean_build()
        assert (returncode == 0) == (expected is not None), stale
        self.counts['launches'] += 1
        if expected is None:
            self.counts['failed builds'] += 1
            return
        after = contents(self.root / 'install')
        assert after == expected, stale
        for name, reason in stale.items():
            self.counts['builds'] += 1
            if before.get(name) == after[name]:
                self.counts['needless builds'] += 1
                event(f'needless build: {reason}')


def set_time(file: Path, later: float) -> None:
    moment = time.time() + later
    os.utime(file, (moment, moment))


def contents(install: Path) -> dict[str, dict[str, str]]:
    """Get what each package installed, without what is colcon's."""
    found: dict[str, dict[str, str]] = {}
    for name in PACKAGES:
        files = found.setdefault(name, {})
        prefix = install / name
        for path in prefix.rglob('*'):
            relative = str(path.relative_to(prefix))
            if path.is_dir() or is_of_colcon(name, relative):
                continue
            mode = bool(path.stat().st_mode & 0o100) if path.exists() else ''
            files[relative] = f'{mode} {content(path)}'
    return found


def content(path: Path) -> str:
    if not path.exists():
        return 'dangling'
    if path.name == 'top':
        done = subprocess.run([path], capture_output=True, text=True)
        return done.stdout
    return path.read_text()


def is_of_colcon(name: str, relative: str) -> bool:
    own = (f'share/{name}/package.', f'share/{name}/hook/')
    return relative.startswith(('share/colcon-core/', *own))


@pytest.fixture
def laboratory(workspace) -> Iterator[Laboratory]:
    with workspace.start(LOOP, stdin=subprocess.PIPE) as process:
        made = Laboratory(workspace, process)
        try:
            made.make()
            yield made
        finally:
            process.kill()
    print('needless builds and others:', dict(made.counts))


#: A launch and a clean build take some two seconds.
_IS_LONG = os.environ.get('HYPOTHESIS_PROFILE') == 'long'
bounded = settings(
    max_examples=100 if _IS_LONG else 4,
    deadline=None,
    suppress_health_check=list(HealthCheck),
)


@bounded
@given(launches)
@example([[('edit', 'base/include/base.h', 2, -HOUR)]])
def test_launch_gives_what_a_clean_build_gives(laboratory, edited) -> None:
    laboratory.reset()
    for group in edited:
        for edit in group:
            laboratory.apply(edit)
        laboratory.launch_and_compare()
