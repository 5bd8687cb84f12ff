# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Random edits, after each of which a fresh bash gives the same."""

from collections.abc import Callable
import os
from pathlib import Path
import shutil
import tempfile

from colcon_yamllaunch.workspace.environment.environment_cache import (
    cached_environment,
)
from hypothesis import given, settings
from hypothesis import strategies as st
import pytest
from support.file_clock import let_files_settle
from support.install_space import in_bash, InstallSpace

pytestmark = pytest.mark.full

#: Each edit sources in a bash with Python in it.
EXAMPLES = 6
NAMES = st.sampled_from('abc')
LINES = st.sampled_from(
    (
        'prepend-non-duplicate;AMENT_PREFIX_PATH;',
        'prepend-non-duplicate;PATH;bin;sbin',
        'prepend-non-duplicate-if-exists;PATH;here',
        'append-non-duplicate;LAST;lib',
        'set;HERE;here',
        'set;TEXT;a $HOME b',
        'set;TEXT;"quoted"',
        'set-if-unset;TEXT;c',
        'set;PATH;/usr/bin:/bin',
        'source;share/none.sh',
        '# comment',
        'damaged',
    )
)
SCRIPTS = ('setup.bash', 'local_setup.bash', '_local_setup_util_sh.py')


class Edited:
    """Two install spaces, one on top of the other, and a caller."""

    def __init__(self, root: Path, merged: bool) -> None:
        self.below = InstallSpace(root / 'below', merged=not merged)
        chained = [self.below.path]
        self.above = InstallSpace(root / 'install', merged, chained)
        for space in (self.below, self.above):
            space.package('a')
        self.build = root / 'build'
        self.build.mkdir()
        self.environment = {'PATH': os.defpath, 'HOME': str(root)}

    def check(self, times: int) -> None:
        environment = self.environment
        results = [
            cached_environment(self.above.setup, environment, self.build)
            for _ in range(times)
        ]
        raw = {os.fsencode(k): os.fsencode(v) for k, v in environment.items()}
        expected = in_bash(self.above.setup, raw, self.build)
        for result in results:
            assert {
                os.fsencode(k): os.fsencode(v)
                for k, v in result.variables.items()
            } == expected


def _hook(space: InstallSpace, name: str, lines: list[str]) -> None:
    space.package(name, *lines)


def _truncate(space: InstallSpace, name: str, size: int) -> None:
    path = space.prefix(name) / f'share/{name}/hook/own.dsv'
    if path.is_file():
        os.truncate(path, min(size, path.stat().st_size))


def _needs(space: InstallSpace, name: str, other: str) -> None:
    space.write(name, f'share/colcon-core/packages/{name}', other)


def _remove(space: InstallSpace, name: str) -> None:
    shutil.rmtree(space.prefix(name) / f'share/{name}', ignore_errors=True)


def _script(space: InstallSpace, name: str, text: str) -> None:
    space.package(name, script=f'export SCRIPT={text}\n')


def _folder(space: InstallSpace, name: str) -> None:
    folder = space.prefix(name) / 'here'
    if folder.exists():
        folder.rmdir()
    else:
        folder.mkdir(parents=True)


def _append(space: InstallSpace, name: str, line: str) -> None:
    with (space.path / name).open('a') as file:
        file.write(line)


def _touch(space: InstallSpace, name: str) -> None:
    os.utime(space.path / name)


def _call(
    edit: Callable[..., None], *arguments: st.SearchStrategy[object]
) -> st.SearchStrategy[tuple[object, ...]]:
    return st.tuples(
        st.just(edit), st.sampled_from(('below', 'above')), *arguments
    )


EDITS = st.one_of(
    _call(_hook, NAMES, st.lists(LINES, min_size=1, max_size=3)),
    _call(_truncate, NAMES, st.integers(0, 40)),
    _call(_needs, NAMES, NAMES),
    _call(_remove, NAMES),
    _call(_script, NAMES, NAMES),
    _call(_folder, NAMES),
    _call(_append, st.sampled_from(SCRIPTS), st.sampled_from(('\n', '#\n'))),
    _call(_touch, st.sampled_from(SCRIPTS)),
    st.tuples(
        st.sampled_from(('TEXT', 'LAST', 'AMENT_PREFIX_PATH', 'PYTHONPATH')),
        st.sampled_from(('', 'x', '/x:/y', '\udcff', '/*', None)),
    ),
)


@pytest.mark.parametrize('merged', [False, True])
@settings(max_examples=EXAMPLES, deadline=None)
@given(steps=st.lists(st.tuples(EDITS, st.booleans()), max_size=4))
def test_cache_gives_what_sourcing_gives_after_edits(merged, steps):
    with tempfile.TemporaryDirectory() as folder:
        edited = Edited(Path(folder).resolve(), merged)
        let_files_settle(Path(folder))
        edited.check(times=1)
        for (what, *arguments), settles in steps:
            if callable(what):
                space = getattr(edited, arguments.pop(0))
                what(space, *arguments)
            elif arguments[0] is None:
                edited.environment.pop(what, None)
            else:
                edited.environment[what] = arguments[0]
            if settles:
                let_files_settle(Path(folder))
            edited.check(times=2)
