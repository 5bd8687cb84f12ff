# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Somebody who edits files at random, and knows what has to run then.

`edited_workspace` has a workspace with files of all kinds, each with a word
that some process says: `whole` always, `ros` and `python` on demand. `base`
has a header and an interface, `flow` is compiled with them and has scripts,
files with parameters and launch files, `brain` is a Python package below a
symbolic link and imports `pylib`. Each process prints at its start what it was
made from: a word of each file that it comes from.
"""

from collections.abc import Callable
from contextlib import suppress
import os
from pathlib import Path
import random
import re
import shutil
import signal
import subprocess
import time

from support.manifest import manifest

_WORKSPACE = Path(__file__).with_name('edited_workspace')
#: The word of a file.
WORD = re.compile(r'\bv\d+\b')
_DEMO = 'flow/launch/demo.yaml'
_INCLUDE = '- include: {{file: $(find-pkg-share {})/launch/{}}}\n'
FURTHER_CMAKE = """\
cmake_minimum_required(VERSION 3.16)
project({name} NONE)
install(PROGRAMS run.py DESTINATION lib/{name})
"""
FURTHER = """\
#!/usr/bin/env python3
import signal
print('{name} says v0', flush=True)
signal.signal(signal.SIGINT, signal.SIG_DFL)
signal.pause()
"""
#: Whose words each process says, in this order.
SAYS = {
    'talk': (
        *('flow/scripts/talk.py', 'flow/scripts/helper.py'),
        *('flow/config/view.rviz', 'flow/config/linked.yaml'),
        'flow/config/talk.yaml',
    ),
    'loop': ('flow/src/loop.c', 'flow/src/word.c', '../elsewhere/fast.h'),
    'other': (
        *('flow/src/other.c', 'flow/CMakeLists.txt'),
        *('base/include/base/base.h', 'base/msg/Word.msg'),
    ),
    'mind': (
        'brain/brain/think.py',
        'pylib/pylib/words.py',
        'flow/launch/demo.yaml',
        'flow/launch/demo.yaml',
    ),
}
#: What stands before the number of a word where processes sleep for it.
SLEEPS = {
    'flow/launch/third.launch.py': '200000',
    'flow/launch/seconds.py': '300000',
}
#: The same of nodes of ROS.
SAYS_IN_ROS = {
    'camera': ('robot/camera.py', 'robot/config/camera.yaml'),
    'box': ('robot/config/box.yaml',),
}
MORE = 'flow/launch/more.yaml'
#: Folders that are away for a while, or replaced by others.
FOLDERS = ('flow/scripts', 'flow/config', 'brain/brain', 'pylib', 'base')


def read_files(kind: str) -> dict[str, str]:
    """Return the text of each file, by its path relative to `src`."""
    folder = _WORKSPACE / kind
    return {
        os.path.relpath(file, folder / 'src'): file.read_text()
        for file in folder.rglob('*')
        if file.is_file() and file.suffix != '.pyc'
    }


def more(sleeps: list[int], packages: list[str]) -> str:
    """Return the launch file that is included."""
    return 'launch:\n' + ''.join(
        [
            *(
                f'- executable: {{cmd: sleep {n}, name: further}}\n'
                for n in (1000, *sleeps)
            ),
            *(
                f'- node: {{pkg: {name}, exec: run.py, name: {name}}}\n'
                for name in packages
            ),
        ]
    )


def further_package(name: str) -> dict[str, str]:
    """Return the files of a package that comes and goes."""
    return {
        f'{name}/package.xml': manifest(name, 'cmake'),
        f'{name}/CMakeLists.txt': FURTHER_CMAKE.format(name=name),
        f'{name}/run.py': FURTHER.format(name=name),
    }


class Editor:
    """
    Edits a workspace.

    :param seed: What the edits come from
    :param offset: Where in the series of words to begin, between 0 and 1
    :param kind: Whether there are nodes of ROS, or launch files in Python, too
    """

    def __init__(
        self, root: Path, seed: str, offset: float, kind: str
    ) -> None:
        self._offset = offset
        self._root = root
        self._source = root / 'src'
        self._chance = random.Random(seed)
        self._version = 0
        #: What each file is to say.
        self.whole = read_files('whole') | {MORE: more([], [])}
        self.says = dict(SAYS)
        match kind:
            case 'ros':
                self.whole |= read_files(kind)
                self.whole[_DEMO] += _INCLUDE.format('robot', 'robot.yaml')
                package = self.whole['flow/package.xml']
                self.whole['flow/package.xml'] = package.replace(
                    '<depend>', '<exec_depend>robot</exec_depend><depend>'
                )
                self.says |= SAYS_IN_ROS
            case 'python':
                self.whole |= read_files(kind)
                self.whole[_DEMO] += _INCLUDE.format('flow', 'third.launch.py')
        self.sleeps: list[int] = []
        self.packages: list[str] = []
        # whose words come next, so that each has its turn
        self._turn: list[str] = []
        #: Returns what runs, and tells what is built.
        self.running: Callable[[], dict[str, int]] = dict
        self.edits: list[Callable[[], None]] = [
            *(self._word, self._word, self._word, self._word),
            *(self._come, self._go, self._break, self._delete, self._touch),
            *(self._repeat, self._unused, self._mode, self._move, self._swap),
            *(self._check_out, self._crash, self._lose, self._new_file),
            *(self._flicker, self._flicker),
        ]

    def lay_out(self) -> None:
        """Write all files, and the symbolic links among them."""
        (self._root / 'elsewhere/brain').mkdir(parents=True)
        (self._root / 'src').mkdir()
        (self._root / 'src/brain').symlink_to('../elsewhere/brain')
        linked = self._root / 'src/flow/config/linked.yaml'
        linked.parent.mkdir(parents=True)
        linked.symlink_to(self._root / 'linked.yaml')
        self._mend()
        self._write(self._source / '.gitignore', '*.egg-info\n__pycache__\n')
        self._git('init', '-q')
        self._git('config', 'user.email', 'someone@example.com')
        self._git('config', 'user.name', 'Someone')

    def burst(self) -> list[str]:
        """Edit this and that, until all is whole."""
        done = []
        if self._chance.random() < 0.5:
            # what follows hides behind nothing else
            self._only_word()
            return ['_only_word']
        for _ in range(self._chance.randrange(1, 6)):
            edit = self._chance.choice(self.edits)
            edit()
            done.append(edit.__name__)
            time.sleep(self._chance.choice((0.0, 0.0, 0.05, 0.3, 1.0, 2.0)))
        self._mend()
        return done

    def expected(self) -> dict[str, str]:
        """Return the last line of each node."""
        lines = {
            label: ' '.join([label, 'says', *map(self._word_of, names)])
            for label, names in self.says.items()
        }
        if 'box' in lines:
            # what prints its parameters
            lines['box'] = lines['box'].replace('box says', 'word: STRING')
        for name in self.packages:
            lines[name] = f'{name} says {self._word_of(f"{name}/run.py")}'
        return lines

    def expected_sleeps(self) -> list[str]:
        """Return for how long what says nothing sleeps."""
        found = ['1000', *map(str, self.sleeps)]
        for name, start in SLEEPS.items():
            if name in self.whole:
                found.append(self._word_of(name).replace('v', start))
        return sorted(found)

    def _word_of(self, name: str) -> str:
        found = WORD.search(self.whole[name])
        assert found is not None, name
        return found[0]

    def _git(self, *words: str) -> None:
        subprocess.run(
            ['git', '-c', 'core.fsync=none', *words],
            cwd=self._source,
            check=True,
            stdout=subprocess.DEVNULL,
        )

    def _next(self) -> str:
        self._version += 1
        return f'v{self._version}'

    def _any(self) -> str:
        return self._chance.choice(sorted(self.whole))

    def _write(self, file: Path, text: str) -> None:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)

    def _save(self, name: str, text: str) -> None:
        file = self._source / name
        file.parent.mkdir(parents=True, exist_ok=True)
        match self._chance.randrange(4):
            case 0:
                file.write_text(text)
            case 1 if not file.is_symlink():
                # as vim does: a probe, a backup, a new file
                probe = file.with_name('4913')
                probe.touch()
                probe.unlink()
                backup = file.with_name(f'{file.name}~')
                if file.exists():
                    file.rename(backup)
                file.write_text(text)
                backup.unlink(missing_ok=True)
            case 2 if not file.is_symlink():
                draft = file.with_name(f'.{file.name}.tmp')
                draft.write_text(text)
                draft.chmod(self._mode_of(name))
                draft.rename(file)
            case _:
                # in two goes
                file.write_text(text[: len(text) // 2])
                file.write_text(text)
        file.chmod(self._mode_of(name))

    def _mode_of(self, name: str) -> int:
        return (
            0o755
            if name.endswith(('talk.py', 'run.py', 'camera.py'))
            else 0o644
        )

    # edits that stay

    def _word(self) -> None:
        """Have a file say something else."""
        self._change(self._chance.choice(self._with_words()))

    def _only_word(self) -> None:
        """Have a file say something else, each in its turn."""
        if not self._turn:
            names = self._with_words()
            random.Random(0).shuffle(names)
            begin = int(self._offset * len(names))
            self._turn = [*names[begin:], *names[:begin]]
        name = self._turn.pop()
        if name in self.whole:
            self._change(name)

    def _with_words(self) -> list[str]:
        return [n for n in sorted(self.whole) if WORD.search(self.whole[n])]

    def _change(self, name: str) -> None:
        text = WORD.sub(self._next(), self.whole[name])
        self.whole[name] = text
        self._save(name, text)

    def _come(self) -> None:
        """Add a process, or a package with one."""
        if self._chance.random() < 0.6 or len(self.packages) == 2:
            self.sleeps.append(100_000 + int(self._next()[1:]))
        else:
            name = f'further_{self._next()}'
            self.packages.append(name)
            for path, text in further_package(name).items():
                self.whole[path] = text
                self._save(path, text)
        self._include()

    def _go(self) -> None:
        if self.packages and self._chance.random() < 0.5:
            name = self.packages.pop(0)
            for path in [n for n in self.whole if n.startswith(f'{name}/')]:
                del self.whole[path]
            if self._chance.random() < 0.5:
                self._include()
            shutil.rmtree(self._source / name, ignore_errors=True)
        elif self.sleeps:
            self.sleeps.remove(self._chance.choice(self.sleeps))
        self._include()

    def _include(self) -> None:
        self.whole[MORE] = more(self.sleeps, self.packages)
        self._save(MORE, self.whole[MORE])

    def _new_file(self) -> None:
        """Add a module, a header or a source that nobody uses."""
        name = self._chance.choice(
            ('brain/brain/{}.py', 'flow/src/{}.c', 'base/include/base/{}.h')
        ).format(self._next())
        text = '' if name.endswith('.py') else '/* nothing */\n'
        self.whole[name] = text
        self._save(name, text)

    def _check_out(self) -> None:
        """Change many files as git does, for good or to and fro."""
        self._mend()
        self._git('add', '-A')
        self._git('commit', '-q', '--allow-empty', '-m', 'one')
        before = dict(self.whole)
        names = self._with_words()
        for name in self._chance.sample(names, min(len(names), 12)):
            text = WORD.sub(self._next(), self.whole[name])
            self.whole[name] = text
            self._write(self._source / name, text)
        for number in range(8):
            name = f'flow/src/many_{number}.c'
            self.whole[name] = f'/* {self._next()[1:]} */\n'
            self._write(self._source / name, self.whole[name])
        self._git('add', '-A')
        self._git('commit', '-q', '-m', 'two')
        if self._chance.random() < 0.7:
            time.sleep(self._chance.choice((0.0, 0.3, 2.0)))
            self._git('checkout', '-q', 'HEAD~1')
            # what links lead to is not in the repository
            kept = ('brain/', '../', 'flow/config/linked.yaml')
            for name in set(self.whole) - set(before):
                del self.whole[name]
            for name, text in before.items():
                if not name.startswith(kept):
                    self.whole[name] = text

    # edits that do not stay

    def _break(self) -> None:
        name = self._any()
        self._save(name, '}{ this is broken (\n' + self.whole[name])

    def _delete(self) -> None:
        (self._source / self._any()).unlink(missing_ok=True)

    def _repeat(self) -> None:
        name = self._any()
        self._save(name, self.whole[name])

    def _touch(self) -> None:
        file = self._source / self._any()
        if file.exists():
            os.utime(file)

    def _mode(self) -> None:
        file = self._source / self._any()
        if file.exists() and not file.is_symlink():
            file.chmod(file.stat().st_mode ^ 0o111)

    def _unused(self) -> None:
        for name in ('.git/note', 'flow/README.md~', 'flow/#talk.py#'):
            self._write(self._source / name, self._next())
        self._write(self._root / 'notes.txt', self._next())

    def _move(self) -> None:
        """Rename a folder; the next to mend renames it again."""
        folder = self._source / self._chance.choice(FOLDERS)
        other = folder.with_name(f'{folder.name}_away')
        if folder.exists() and not other.exists():
            folder.rename(other)

    def _lose(self) -> None:
        """Delete a folder."""
        folder = self._source / self._chance.choice(FOLDERS)
        if folder.exists() and not folder.is_symlink():
            shutil.rmtree(folder)

    def _swap(self) -> None:
        """Put another folder in the place of one."""
        folder = self._source / self._chance.choice(FOLDERS)
        if not folder.exists():
            return
        self._mend()
        new = folder.with_name(f'.{folder.name}.new')
        shutil.copytree(folder, new, symlinks=True)
        prefix = f'{folder.relative_to(self._source)}/'
        names = [
            n
            for n in sorted(self.whole)
            if n.startswith(prefix) and WORD.search(self.whole[n])
        ]
        name = self._chance.choice(names)
        text = WORD.sub(self._next(), self.whole[name])
        self.whole[name] = text
        (new / name.removeprefix(prefix)).write_text(text)
        old = folder.with_name(f'.{folder.name}.old')
        folder.rename(old)
        new.rename(folder)
        shutil.rmtree(old)

    def _flicker(self) -> None:
        """Have a file away for a moment while a process reads it."""
        label = self._chance.choice(('talk', 'mind'))
        first, second = self._chance.sample(SAYS[label], 2)
        before = self.running().get(label)
        self._change(first)
        deadline = time.monotonic() + 1.0
        while self.running().get(label) == before:
            if time.monotonic() > deadline:
                break
            time.sleep(0.01)
        time.sleep(self._chance.choice((0.0, 0.03, 0.1)))
        file = self._source / second
        file.unlink(missing_ok=True)
        time.sleep(self._chance.choice((0.0, 0.05, 0.1)))
        self._write(file, self.whole[second])
        file.chmod(self._mode_of(second))

    def _crash(self) -> None:
        """Have a process crash, and change what it runs."""
        label, names = self._chance.choice(sorted(self.says.items()))
        pid = self.running().get(label)
        if pid is not None:
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        if self._chance.random() < 0.5:
            time.sleep(0.1)
        self._change(self._chance.choice(names))

    def _mend(self) -> None:
        for name in FOLDERS:
            folder = self._source / name
            away = folder.with_name(f'{folder.name}_away')
            if away.exists():
                if folder.exists():
                    shutil.rmtree(folder)
                away.rename(folder)
        linked = self._source / 'flow/config/linked.yaml'
        if not linked.is_symlink():
            linked.unlink(missing_ok=True)
            linked.parent.mkdir(parents=True, exist_ok=True)
            linked.symlink_to(self._root / 'linked.yaml')
        for name, text in self.whole.items():
            file = self._source / name
            if not file.exists() or file.read_text() != text:
                self._save(name, text)
            elif file.stat().st_mode & 0o777 != self._mode_of(name):
                file.chmod(self._mode_of(name))
