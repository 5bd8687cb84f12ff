# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The remote shell of rsync: the connection that the launcher has already.

rsync starts it with the command that is to run there. It hands its standard
input and output to the launcher, with the command, and waits for the exit
code. Only the standard library is used, as it runs with `-I -S`.
"""

import json
import os
import socket
import sys

#: The exit code of ssh when a connection is lost.
LOST = 255


def main() -> int:
    """
    Run; the arguments are a descriptor, the machine and the command.

    The descriptor is a socket that rsync was started with.
    """
    descriptor, _, *command = sys.argv[1:]
    with socket.socket(fileno=int(descriptor)) as launcher:
        message = json.dumps(command).encode()
        socket.send_fds(launcher, [message], [0, 1])
        # rsync is to see the end of what the launcher writes
        null = os.open(os.devnull, os.O_RDWR)
        os.dup2(null, 0)
        os.dup2(null, 1)
        answer = launcher.recv(16)
    return int(answer) if answer else LOST


if __name__ == '__main__':
    sys.exit(main())
