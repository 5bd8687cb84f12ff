# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Send a number to the listener every so often."""

import argparse
import itertools
import signal
import socket
import time

from talk.listener import SOCKET


def positive(text: str) -> float:
    """Read a number of seconds."""
    seconds = float(text)
    if not 0 < seconds <= 86400:
        raise ValueError
    return seconds


def main() -> None:
    """Run until stopped."""
    parser = argparse.ArgumentParser(prog='talker', description=__doc__)
    parser.add_argument(
        '--period',
        type=positive,
        default=1.0,
        help='seconds between two numbers (default: %(default)s)',
    )
    period = parser.parse_args().period
    # SIGTERM is as clean an end as Ctrl-C is.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as sender:
        try:
            for number in itertools.count(1):
                time.sleep(period)
                print(f'Sending {number}')
                try:
                    sender.sendto(str(number).encode(), str(SOCKET))
                except (FileNotFoundError, ConnectionRefusedError):
                    print('Nobody listens')
        except KeyboardInterrupt:
            pass
