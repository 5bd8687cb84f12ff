# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The remote shell of rsync: the connection that the launcher has already.

rsync starts it with the command that is to run there. It hands its standard
input and output to the launcher, with the command, and waits for the exit
code. If the launcher is killed meanwhile, it removes the folder with the links
to the files that rsync sends. Only the standard library is used, as it runs
with `-I -S`.
"""

import json
import os
import shutil
import signal
import socket
import sys

#: The exit code of ssh when a connection is lost.
LOST = 255
#: The longest path in bytes.
_PATH = 4096


def main() -> int:
    """
    Run; the arguments are a descriptor, the machine and the command.

    The descriptor is a socket that rsync was started with.
    """
    # rsync sends this when it fails, as it does when the launcher is killed
    signal.signal(signal.SIGUSR1, signal.SIG_IGN)
    descriptor, _, *command = sys.argv[1:]
    with socket.socket(fileno=int(descriptor)) as launcher:
        message = json.dumps(command).encode()
        socket.send_fds(launcher, [message], [0, 1])
        # rsync is to see the end of what the launcher writes
        null = os.open(os.devnull, os.O_RDWR)
        os.dup2(null, 0)
        os.dup2(null, 1)
        folder = os.fsdecode(launcher.recv(_PATH))
        answer = launcher.recv(16)
    if not answer and folder:
        shutil.rmtree(folder, ignore_errors=True)
    return int(answer) if answer else LOST


if __name__ == '__main__':
    sys.exit(main())
