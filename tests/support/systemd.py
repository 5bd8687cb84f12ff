# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What systemd does for a service, played on sockets of a test."""

import os
from pathlib import Path
import socket
import subprocess
import sys
import time

from support.user import DEADLINE, User

#: Runs `colcon` with another journal, and with other folders of the system.
PROGRAM = """\
import os
from pathlib import Path
import sys
from colcon_yamllaunch.control import socket_folder
from colcon_yamllaunch.service import journald
from colcon_yamllaunch.verb import services
folder = Path(sys.argv.pop(1))
journald.SOCKET = str(folder / 'journal')
socket_folder.SERVICE_FOLDERS = folder / 'run'
services.BOOTED = folder / 'booted'
services._SYSTEM = services._Scope(
    True, folder / 'etc/services', folder / 'etc/system', 'multi-user'
)
if 'PLAYED_USER' in os.environ:
    os.geteuid = lambda: int(os.environ['PLAYED_USER'])
from colcon_core.command import main
sys.exit(main())
"""


class Systemd:
    """
    Plays systemd for a launch.

    :param folder: Has the sockets, and stands for `/etc` and `/run`
    """

    def __init__(self, folder: Path, user: User) -> None:
        self.folder = folder
        self._user = user
        self._notify = _socket(folder / 'notify')
        self._journal = _socket(folder / 'journal')
        self._program = folder / 'colcon'
        self._program.write_text(PROGRAM, encoding='utf-8')
        self._launch: subprocess.Popen[bytes] | None = None
        #: All that was received.
        self.notified: list[str] = []

    def words(self, *words: str) -> list[str]:
        """Return the command line of `colcon launch` here."""
        first = [sys.executable, str(self._program), str(self.folder)]
        return [*first, 'launch', *words]

    def run(self, *words: str) -> subprocess.CompletedProcess[str]:
        """Run `colcon launch` to its end, as a user does."""
        return subprocess.run(
            self.words(*words),
            cwd=self._user.root,
            env=self._user.environment,
            capture_output=True,
            text=True,
            timeout=DEADLINE,
        )

    def start(
        self, *words: str, watchdog: float | None = None
    ) -> 'subprocess.Popen[bytes]':
        """Start `colcon launch` as a service with output to the journal."""
        log = (self.folder / 'stdout').open('wb')
        status = os.fstat(log.fileno())
        variables = {
            'NOTIFY_SOCKET': str(self.folder / 'notify'),
            'JOURNAL_STREAM': f'{status.st_dev}:{status.st_ino}',
            'COLCON_LOG_PATH': '/dev/null',
        }
        if watchdog is not None:
            variables['WATCHDOG_USEC'] = str(int(watchdog * 1e6))
        with log:
            self._launch = subprocess.Popen(
                self.words(*words),
                cwd='/',
                env=self._user.environment | variables,
                stdout=log,
                start_new_session=True,
            )
        return self._launch

    def wait_for(self, line: str) -> None:
        """Wait until a line was sent to systemd."""
        deadline = time.monotonic() + DEADLINE
        while line not in self.notified:
            assert time.monotonic() < deadline, self.notified
            self.receive(0.1)

    def receive(self, seconds: float) -> list[str]:
        """Receive for some seconds, and return what came."""
        known = len(self.notified)
        deadline = time.monotonic() + seconds
        while (left := deadline - time.monotonic()) > 0:
            self._notify.settimeout(left)
            try:
                data = self._notify.recv(1 << 16)
            except TimeoutError:
                break
            self.notified += data.decode().splitlines()
        return self.notified[known:]

    def journal(self) -> list[dict[str, str]]:
        """Return the messages that the journal has got."""
        found = []
        self._journal.setblocking(False)
        while True:
            try:
                data = self._journal.recv(1 << 18).decode()
            except BlockingIOError:
                return found
            lines = data.splitlines()
            found.append(dict(line.split('=', 1) for line in lines))

    def close(self) -> None:
        """Leave nothing behind."""
        if self._launch is not None and self._launch.poll() is None:
            self._launch.terminate()
            self._launch.wait(timeout=DEADLINE)
        self._notify.close()
        self._journal.close()


def _socket(path: Path) -> socket.socket:
    found = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    # a whole path may be too long for a socket
    folder = os.open(path.parent, os.O_RDONLY)
    found.bind(f'/proc/self/fd/{folder}/{path.name}')
    os.close(folder)
    return found
