# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What all tests share."""

from collections.abc import Iterator
import random
import signal
import socket

import pytest

# The background job of a script ignores Ctrl-C, nohup makes SIGHUP ignored,
# and so would all that tests start.
signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGHUP, signal.SIG_DFL)

#: The ids whose ports lie below Linux's ephemeral ones (ROS 2's guide to
#: ROS_DOMAIN_ID); 0 is left out, since it is what everybody else uses.
DOMAIN_IDS = range(1, 102)


def _claim(domain_id: int) -> socket.socket | None:
    """
    Claim a domain id on this machine for as long as the socket is open.

    The socket's name is in Linux's abstract namespace, so it leaves no file
    behind, and the claim ends even if the test is killed.
    """
    claim = socket.socket(socket.AF_UNIX)
    try:
        claim.bind(f'\0colcon-yamllaunch-test-domain-{domain_id}')
    except OSError:
        claim.close()
        return None
    return claim


@pytest.fixture
def ros_domain_id() -> Iterator[int]:
    """Give a ROS_DOMAIN_ID that no other running test has."""
    for domain_id in random.sample(DOMAIN_IDS, len(DOMAIN_IDS)):
        claim = _claim(domain_id)
        if claim is not None:
            with claim:
                yield domain_id
            return
    pytest.fail('every ROS_DOMAIN_ID is in use by another test')
