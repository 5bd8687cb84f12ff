# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What the processes of a launch get, by `ros2 launch` and by `colcon launch`.

The programs of the launch files write down how they were started and how they
ended (`prefix/lib/robot_parts`); nothing else is looked at but what the
screen shows of them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
import json
import os
from pathlib import Path
import re
import shutil
import signal
import subprocess
from typing import Any

from tests.conformance.outcome import as_seen

HERE = Path(__file__).parent
FILES = HERE / 'files'
#: Seconds that a launch may take; most take two.
TIMEOUT = 120
#: Where this launcher writes what launch files print.
PRINTS = 'launch_files.log'
#: What differs on purpose, or is different each time.
DROPPED = re.compile(
    r'COLCON_LAUNCH_.*|PYTHONUNBUFFERED|RCUTILS_LOGGING_BUFFERED_STREAM|'
    r'LD_PRELOAD|_STDBUF_[OE]|ROS_LOG_DIR|_|SHLVL|OLDPWD|PWD|'
    # of colcon, which has sourced the workspace, though there is none here
    r'COLCON|_ROS_WHEELS_.*|LD_LIBRARY_PATH'
)
_PROGRAMS = ('part', 'box', 'cycle')


@dataclass(frozen=True)
class Launched:
    """
    What came of a launch.

    :param processes: What they wrote down, in an order that is always the same
    :param notes: What the launch file said, in order
    :param said: What the screen showed of the output of processes, sorted
    :param output: All that the launcher showed
    :param printed: What the launch file printed itself, sorted
    :param code: Its exit code
    """

    processes: list[dict[str, Any]]
    notes: list[str]
    said: list[str]
    output: str
    printed: list[str]
    code: int

    @property
    def outcome(self) -> dict[str, Any]:
        """What is to be the same with both launchers."""
        return {
            'processes': self.processes,
            'notes': self.notes,
            'said': self.said,
        }


class Launches:
    """
    Launches, all of them at the same place, so that paths are the same.

    :param folder: An empty folder
    :param environment: With ROS 2 sourced
    :param python: The Python for the programs
    """

    def __init__(
        self, folder: Path, environment: Mapping[str, str], python: str
    ) -> None:
        self.files = folder / 'files'
        self._folder = folder / 'place'
        prefix = folder / 'prefix'
        shutil.copytree(FILES, self.files)
        shutil.copytree(HERE / 'prefix', prefix)
        (prefix / 'bin').mkdir()
        for name in _PROGRAMS:
            program = prefix / 'lib/robot_parts' / name
            _, _, text = program.read_text(encoding='utf-8').partition('\n')
            program.write_text(f'#!{python}\n{text}', encoding='utf-8')
            (prefix / 'bin' / name).symlink_to(program)
        self.environment = {
            **environment,
            'HOME': str(self._folder / 'home'),
            'RECORDS': str(self._folder / 'records'),
            'XDG_RUNTIME_DIR': str(self._folder / 'run'),
            'T_FROM_SHELL': 'yes',
        }
        for name, path in (
            ('AMENT_PREFIX_PATH', prefix),
            ('PATH', prefix / 'bin'),
            ('PYTHONPATH', prefix / 'python'),
        ):
            before = environment.get(name)
            self.environment[name] = (
                f'{path}:{before}' if before else f'{path}'
            )

    def ros2(self, file: str, *arguments: str) -> Launched:
        """Launch a file with ROS 2's own launcher."""
        return self.run(['ros2', 'launch', '-n', file, *arguments])

    def colcon(self, file: str, *arguments: str) -> Launched:
        """Launch a file with this launcher."""
        return self.run(['colcon', 'launch', file, *arguments])

    def run(self, command: Sequence[str]) -> Launched:
        """
        Run a command to its end.

        A word that is the name of one of the files stands for its path.
        """
        for name in ('cwd', 'home', 'records', 'run'):
            (self._folder / name).mkdir(parents=True, mode=0o700)
        screen = self._folder / 'screen'
        words = [str(self._path(word)) for word in command]
        program = shutil.which(words[0], path=self.environment['PATH'])
        assert program is not None, f'no {words[0]} in PATH'
        with screen.open('wb') as output:
            popen = subprocess.Popen(
                [program, *words[1:]],
                cwd=self._folder / 'cwd',
                env=self.environment,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
        try:
            popen.wait(TIMEOUT)
        except subprocess.TimeoutExpired:
            text = screen.read_text(encoding='utf-8', errors='replace')
            raise AssertionError(f'{command} does not end:\n{text}') from None
        finally:
            if popen.poll() is None:
                _end(popen)
        text = screen.read_text(encoding='utf-8', errors='replace')
        launched = Launched(
            _processes(self._folder / 'records'),
            re.findall('note: (.*)', text),
            sorted(re.findall('said: (.*)', text)),
            text,
            sorted(re.findall('printed: .*', text + self._prints())),
            popen.returncode,
        )
        shutil.rmtree(self._folder)
        return launched

    def _prints(self) -> str:
        """Return what is in the file for what launch files print."""
        files = (self._folder / 'home').rglob(PRINTS)
        texts = (path.read_text(encoding='utf-8') for path in files)
        return ''.join(texts)

    def _path(self, word: str) -> Path | str:
        path = self.files / word
        return path if path.is_file() else word


def _end(popen: 'subprocess.Popen[bytes]') -> None:
    """End a launch that does not end, with all that it started."""
    popen.send_signal(signal.SIGINT)
    try:
        popen.wait(20)
    except subprocess.TimeoutExpired:
        os.killpg(popen.pid, signal.SIGKILL)
        popen.wait()


def _processes(records: Path) -> list[dict[str, Any]]:
    found = []
    for start in records.glob('*.start'):
        process = _read(start)
        end = start.with_suffix('.end')
        more = sorted(
            records.glob(f'{start.stem}.*.json'),
            key=lambda path: int(path.suffixes[0][1:]),
        )
        found.append(
            as_seen(process)
            | {
                'env': {
                    name: value
                    for name, value in process['env'].items()
                    if not DROPPED.fullmatch(name)
                },
                'terminals': process['terminals'],
                # what several actions load comes as it comes
                'more': sorted(map(_read, more), key=_loaded),
                # one that was killed writes nothing
                'end': _read(end) if end.exists() else 'killed',
            }
        )
    return sorted(found, key=lambda one: json.dumps(one, sort_keys=True))


def _read(path: Path) -> Any:
    return json.loads(path.read_text(encoding='utf-8'))


def _loaded(what: Any) -> str:
    """Return what to sort by: components by name, all else as it came."""
    return str(what['node']) if 'component' in what else ''


def differences(ours: Launched, theirs: Launched) -> str:
    """Tell what differs, in lines; empty when nothing does."""
    lines = []
    for name in ('notes', 'said'):
        mine, other = getattr(ours, name), getattr(theirs, name)
        if mine != other:
            lines.append(f'{name}: ros2 {other}\n{name}: ours {mine}')
    rest = list(ours.processes)
    missing = []
    for process in theirs.processes:
        if process in rest:
            rest.remove(process)
        else:
            missing.append(process)
    for process in missing:
        near = [one for one in rest if _word(one) == _word(process)]
        if not near:
            lines.append(f'only with ros2: {_told(process)}')
            continue
        rest.remove(near[0])
        lines.append(f'{" ".join(map(str, _word(process)))}:')
        lines += _changes(near[0], process)
    lines += [f'only with ours: {_told(process)}' for process in rest]
    return '\n'.join(lines)


def _word(process: dict[str, Any]) -> list[Any]:
    first = process['args'][:1]
    return [process['exe'], process['namespace'], process['node'], *first]


def _told(process: dict[str, Any]) -> str:
    kept = {k: v for k, v in process.items() if k != 'env'}
    return json.dumps(kept, ensure_ascii=False)


def _changes(ours: Any, theirs: Any, where: str = '') -> list[str]:
    if isinstance(ours, dict) and isinstance(theirs, dict):
        return [
            line
            for key in sorted({*ours, *theirs})
            for line in _changes(
                ours.get(key, '(none)'),
                theirs.get(key, '(none)'),
                f'{where}.{key}',
            )
        ]
    if ours == theirs:
        return []
    return [f'  {where[1:]}: ros2 {theirs!r}, ours {ours!r}']
