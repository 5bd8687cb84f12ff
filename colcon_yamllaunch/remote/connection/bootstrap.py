# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Starts our program on a machine.

A script for `sh`, sent to its standard input, looks for a Python. That looks
for our modules under their hash in `~/.cache/colcon-launch`. If they are
missing, it requests them, answers each piece with an empty line, and stores
them there; if it cannot, in a private temporary folder until the program ends;
if there is no room either, it reports that. Output of a shell before that,
from its `.bashrc`, is ignored.

Nothing is installed there, so our modules are sent, see :func:`program_files`.
They import only one another and the standard library (a test checks that). The
same sources have the same hash.
"""

from functools import cache, cached_property
import hashlib
import json
from pathlib import Path
import shlex
import threading
from typing import Literal
import zlib

import colcon_yamllaunch
from colcon_yamllaunch.remote.agent.machine_agent import MODULES

#: The beginning of the script's answers. The script has it in two parts, so
#: that a shell that echoes its input does not seem to answer.
MARK = b'\x01colcon-launch '
#: How much a shell may print before that (bytes).
MAXIMUM_NOISE = 256 * 1024
_MAXIMUM_ANSWER = 200

#: The oldest Python that our modules run with, and the names of Pythons.
OLDEST_PYTHON = (3, 10)
_PYTHONS = ('python3', *(f'python3.{minor}' for minor in range(14, 9, -1)))

# for any Python 3; without a single quote, as it stands between two. A Python
# that is too old looks for a younger one itself
_PROGRAM = """\
import os, sys
h, n = sys.argv[1:3]
def say(t):
    os.write(1, b"\\1colcon" + b"-launch " + t.encode() + b"\\n")
if sys.version_info < (3, 10):
    with open("/proc/self/cmdline", encoding="utf-8") as f:
        p = f.read().split("\\0")[4]
    for q in n.split():
        try:
            os.execvp(q, [q, "-I", "-S", "-c", p, h, ""])
        except OSError:
            pass
    say("old " + sys.version.split()[0])
    sys.exit(0)
c = os.environ.get("XDG_CACHE_HOME", "")
if c[:1] != "/":
    c = os.path.expanduser("~/.cache")
c = os.path.join(c, "colcon-launch", "program")
d = os.path.join(c, h)
def own(f):
    s = os.lstat(f)
    return s.st_uid == os.getuid() and s.st_mode & 0o170022 == 0o40000
try:
    has = own(d)
except OSError:
    has = False
t = ""
if not has:
    say("need")
    def take(n):
        b = b""
        while len(b) < n:
            r = os.read(0, n - len(b))
            if not r:
                sys.exit(0)
            os.write(1, b"\\n")
            b += r
        return b
    data = take(int(take(8)))
    import json, shutil, tempfile, zlib
    w = []
    for p, x in ("new-", c), ("colcon-launch-", None):
        try:
            if x:
                os.makedirs(x, 0o700, True)
            t = tempfile.mkdtemp("", p, x)
            for f, s in json.loads(zlib.decompress(data).decode()).items():
                f = os.path.join(t, f)
                os.makedirs(os.path.dirname(f), 0o700, True)
                with open(f, "w", encoding="utf-8") as o:
                    o.write(s)
            break
        except OSError as e:
            w.append(str(e.strerror)[:80])
            shutil.rmtree(t, True)
    else:
        say("full " + "; ".join(w))
        sys.exit(0)
    try:
        os.rename(t, d)
        t = ""
    except OSError:
        try:
            if own(d):
                shutil.rmtree(t, True)
                t = ""
        except OSError:
            pass
sys.path.insert(0, t or d)
from colcon_yamllaunch.remote.agent.machine_agent import main
say("have")
main(t)
"""

# any POSIX shell has read all of it before it does anything. It starts Python
# by its path, without which, and without PATH, that does not know its own
_SCRIPT = """\
{{
p='{program}'
for n in {pythons}; do
if f=$(command -v "$n" 2>/dev/null); then
exec "$f" -I -S -c "$p" {digest} '{younger}'
fi
done
printf '\\001colcon%s\\n' '-launch none'
exit 0
}}
"""

_PACKAGE = colcon_yamllaunch.__name__
_ROOT = Path(colcon_yamllaunch.__file__).parent
#: The files of the package that are sent, as patterns.
_SENT = (
    '__init__.py',
    'run.py',
    *(f'{name}/*.py' for name in ('common', 'control', 'engine')),
    *(f'{name}/*.py' for name in ('observers', 'plan', 'terminal')),
    'workspace/__init__.py',
    *(f'workspace/{name}/*.py' for name in ('building', 'colcon')),
    *(f'workspace/{name}/*.py' for name in ('environment', 'freshness')),
    'workspace/packages/*.py',
    'remote/__init__.py',
    'remote/part_protocol.py',
    'remote/agent/*.py',
    *(f'remote/sync/{name}.py' for name in ('__init__', 'colcon_build')),
    *(f'remote/sync/{name}.py' for name in MODULES),
)
# of those, what only the launcher uses
_NOT_SENT = frozenset(
    (
        *(f'control/{name}.py' for name in ('doubled_nodes', 'selection')),
        *(f'observers/{name}.py' for name in ('junit', 'timeline')),
        *(f'plan/plan_{name}.py' for name in ('difference', 'graph')),
        *(f'plan/plan_{name}.py' for name in ('script', 'text')),
        'plan/member_settings_text.py',
        *(f'terminal/{n}.py' for n in ('client_attachment', 'status_table')),
    )
)
_LOCK = threading.Lock()

State = Literal['noise', 'sending', 'answered', 'failed']
#: The cause: there is no Python, it is too old, the disk is full, or something
#: else answers than our script.
Failure = Literal['none', 'old', 'full', 'noise']


class ProgramArchive:
    """
    The modules that a machine is sent.

    :param files: The modules by their paths
    """

    def __init__(self, files: dict[str, str]) -> None:
        self._text = json.dumps(
            files, sort_keys=True, separators=(',', ':')
        ).encode()
        #: Their SHA-256, in hexadecimal digits.
        self.digest = hashlib.sha256(self._text).hexdigest()

    @cached_property
    def data(self) -> bytes:
        """The packed files."""
        return zlib.compress(self._text, 6)


def program_archive() -> ProgramArchive:
    """Return the modules that machines are sent; thread-safe."""
    with _LOCK:
        return _program_archive()


@cache
def _program_archive() -> ProgramArchive:
    return ProgramArchive(
        {f'{_PACKAGE}/{name}': text for name, text in program_files().items()}
    )


def program_files() -> dict[str, str]:
    """Return the modules that run there, by their paths below the package."""
    return {
        name: path.read_text(encoding='utf-8')
        for pattern in _SENT
        for path in _ROOT.glob(pattern)
        if (name := path.relative_to(_ROOT).as_posix()) not in _NOT_SENT
    }


class Bootstrap:
    """
    The launcher's side of starting the program; does no input or output.

    :param python: The Python there, None to search for one
    """

    def __init__(
        self, archive: ProgramArchive, python: str | None = None
    ) -> None:
        self._archive = archive
        self._python = python
        self._data = b''
        #: The progress.
        self.state: State = 'noise'
        #: The cause if it has failed.
        self.failure: Failure = 'noise'
        #: More about the cause, such as the version.
        self.detail = ''

    def script(self) -> bytes:
        """Return the script, which is sent first."""
        pythons = _PYTHONS if self._python is None else (self._python,)
        younger = _PYTHONS[1:] if self._python is None else ()
        text = _SCRIPT.format(
            program=_PROGRAM,
            pythons=shlex.join(pythons),
            digest=self._archive.digest,
            younger=' '.join(younger),
        )
        return text.encode()

    def feed(self, data: bytes) -> tuple[bytes, bytes]:
        """
        Process received data.

        Return the data to send, if :attr:`state` is `sending`, and what
        follows the last answer, if it is `answered`.
        """
        self._data += data
        before, found, rest = self._data.partition(MARK)
        answer, ended, frames = rest.partition(b'\n')
        if not (found and ended):
            if len(before) > MAXIMUM_NOISE or len(answer) > _MAXIMUM_ANSWER:
                self.state = 'failed'
            return b'', b''
        word, _, detail = answer.decode(errors='replace').partition(' ')
        self.detail = detail.strip()
        if word == 'have':
            self.state = 'answered'
            self._data = b''
            return b'', frames
        if word == 'need' and self.state == 'noise':
            self.state = 'sending'
            self._data = b''
            packed = self._archive.data
            _, rest = self.feed(frames)
            return f'{len(packed):8d}'.encode() + packed, rest
        self.state = 'failed'
        if word in ('none', 'old', 'full'):
            self.failure = word  # type: ignore[assignment]
        return b'', b''

    @property
    def noise(self) -> str:
        """The output of the shell before the answer."""
        text = self._data.partition(MARK)[0][-_MAXIMUM_ANSWER:]
        return text.decode(errors='replace').strip()
