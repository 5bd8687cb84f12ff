# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Digests that tell whether something is still the same."""

try:
    # hashlib loads OpenSSL, which takes each launch some 5 ms; Python's own
    # `random` goes past it, too
    from _blake2 import blake2b
except ImportError:
    from hashlib import blake2b

#: Bytes; so long that no two contents share a digest by accident.
_SIZE = 16


def digest(content: bytes) -> str:
    """Return the digest of a content, as a hexadecimal number."""
    return blake2b(content, digest_size=_SIZE).hexdigest()
