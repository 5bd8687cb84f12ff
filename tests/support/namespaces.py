# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
A machine made of namespaces: processes and a network of its own.

A command runs another one there, as `docker exec -i` does: one that is
killed leaves what it started. The machine ends with its first process, and
everything there with it, as at a power cut.
"""

import contextlib
import functools
import os
from pathlib import Path
import shlex
import shutil
import subprocess
import sys
import uuid

import pytest
from support.marked_processes import (
    command_of,
    DEADLINE,
    descendants,
    kill,
    marked,
    wait_until_none,
)
from support.system_servers import run_quietly, start_server
from support.waiting import wait_until

#: The variable by which what runs on the machine is found.
MARK = 'COLCON_LAUNCH_TEST_NAMESPACE'

_KINDS = ('--pid', '--net', '--mount')
#: The first process: it takes what others leave, as any init.
_INIT = """\
ip link set lo up 2>/dev/null
touch "$1"
while :; do
  sleep 1000 &
  wait
done
"""
#: What runs a command there.
_ENTER = """\
#!/bin/sh
if [ ! -s {init} ]; then
  echo "Error: the machine does not run" >&2
  exit 1
fi
exec nsenter --target "$(cat {init})" {kinds} -- {env} "$@"
"""


@functools.cache
def _rights() -> tuple[str, ...] | None:
    """Return the options with which namespaces may be made, if any."""
    if shutil.which('nsenter') is None:
        return None
    for options in ((), ('--user', '--map-root-user')):
        argv = ['unshare', *options, *_KINDS, '--fork', '--mount-proc', 'true']
        with contextlib.suppress(OSError):
            if subprocess.run(argv, capture_output=True).returncode == 0:
                return options
    return None


def skip_without_namespaces() -> None:
    """Skip the test where no machine can be made of namespaces."""
    if _rights() is None:
        pytest.skip(
            'namespaces for processes and networks need root, or a user '
            'namespace, and nsenter (Debian: util-linux)'
        )


class NamespaceMachine:
    """
    A machine that a command leads to.

    :ivar home: Its home folder
    :ivar enter: The program that runs its arguments there, also after a
        reboot
    """

    def __init__(self, folder: Path) -> None:
        self.home = folder / 'home'
        self.enter = folder / 'enter'
        self._init = folder / 'init'
        self._ready = folder / 'ready'
        self._mark = uuid.uuid4().hex
        self._server: subprocess.Popen[bytes] | None = None

    def __enter__(self) -> 'NamespaceMachine':
        self.home.mkdir()
        programs = Path(sys.executable).parent
        env = [
            'env',
            '-i',
            f'HOME={self.home}',
            f'XDG_RUNTIME_DIR={self.home}',
            f'PATH={programs}:{os.environ["PATH"]}',
            f'{MARK}={self._mark}',
        ]
        kinds = [*_KINDS]
        if _rights():
            kinds += ['--user', '--preserve-credentials']
        text = _ENTER.format(
            init=shlex.quote(str(self._init)),
            kinds=shlex.join(kinds),
            env=shlex.join(env),
        )
        self.enter.write_text(text, encoding='utf-8')
        self.enter.chmod(0o755)
        try:
            self.start()
        except BaseException:
            self.power_off()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self.power_off()

    def start(self) -> None:
        """Start the machine, after `power_off()`."""
        rights = _rights()
        assert rights is not None
        self._ready.unlink(missing_ok=True)
        init = ['sh', '-c', _INIT, 'init', str(self._ready)]
        how = ['--fork', '--kill-child', '--mount-proc']
        server = start_server(['unshare', *rights, *_KINDS, *how, *init])
        self._server = server
        wait_until(lambda: self._ready.exists() or server.poll() is not None)
        (first,) = _children(server.pid)
        self._init.write_text(f'{first}\n', encoding='utf-8')

    def power_off(self) -> None:
        """End everything there at once; nobody is told."""
        server, self._server = self._server, None
        self._init.unlink(missing_ok=True)
        if server is None:
            return
        # the first one is killed by the kernel's rules for PID namespaces,
        # and takes all others along
        kill(_children(server.pid))
        kill([server.pid])
        server.wait()
        while doomed := marked(MARK, self._mark):
            kill(doomed)

    def reboot(self) -> None:
        """End everything there at once, and start the machine again."""
        self.power_off()
        self.start()

    def run(self, *words: str) -> 'subprocess.CompletedProcess[str]':
        """Run a command there."""
        return run_quietly([self.enter, *words])

    def left(self) -> list[str]:
        """Return the command lines of all that was started there."""
        return [command_of(pid) for pid in marked(MARK, self._mark)]

    def wait_until_empty(self, seconds: float = DEADLINE) -> float:
        """Wait until nothing runs there, and return how long it took."""
        return wait_until_none(self.left, seconds)


def _children(pid: int) -> list[int]:
    """Return the children of a process, without theirs."""
    found = descendants(pid)
    below = {deeper for child in found for deeper in descendants(child)}
    return [child for child in found if child not in below]
