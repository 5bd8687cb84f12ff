# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Print each number that arrives, and twice that number."""

from pathlib import Path
import signal
import socket

SOCKET = Path('talk.socket')


def main() -> None:
    """Run until stopped."""
    # SIGTERM is as clean an end as Ctrl-C is.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    # A listener that was killed leaves its socket.
    SOCKET.unlink(missing_ok=True)
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as receiver:
        receiver.bind(str(SOCKET))
        try:
            while True:
                number = int(receiver.recv(64))
                print(f'Heard {number}, twice that is {number * 2}')
        except KeyboardInterrupt:
            pass
        finally:
            SOCKET.unlink(missing_ok=True)
