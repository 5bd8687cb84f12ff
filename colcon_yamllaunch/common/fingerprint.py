# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Whether files and folders have changed.

Sizes and times tell that without reading a file, except if it was written
within the last tick of the file system's clock; then its content is compared.
"""

from collections.abc import Iterable
import os
from pathlib import Path
import stat
import time
from typing import NamedTuple

try:
    # hashlib loads OpenSSL, which takes each launch some 5 ms; Python's own
    # `random` goes past it, too
    from _blake2 import blake2b
except ImportError:
    from hashlib import blake2b

#: How long after a change another one may get the same time (nanoseconds).
#: Linux counts file times in ticks of up to 10 ms, some file systems in
#: seconds.
TICK = 20_000_000
COARSE_TICK = 2_000_000_000
#: Larger files are told apart by size and times only, unless their content is
#: asked for (bytes).
READ_SIZE = 8 * 1024 * 1024
#: How much of one is read at once (bytes).
_CHUNK = 1024 * 1024

#: Bytes; so long that no two contents share a digest by accident.
_DIGEST_SIZE = 16
_SECOND = 1_000_000_000


class Fingerprint(NamedTuple):
    """
    The size, times and content of a file or folder; a list in JSON.

    :param size: Bytes; -1 for a folder, whose times tell as much
    :param mtime: When it was last written (nanoseconds), or 0 where that
      proves nothing
    :param executable: Whether its owner may run it
    :param digest: That of its content; empty if it was not or cannot be read
    :param ctime: When it was last written or given another time, mode or name
      (nanoseconds); unlike the other time no program can set it
    :param inode: The number of the file, or 0 where it is not compared
    """

    size: int
    mtime: int
    executable: bool
    digest: str = ''
    ctime: int = 0
    inode: int = 0

    @classmethod
    def of(cls, status: os.stat_result) -> 'Fingerprint':
        """Return the fingerprint of what has a status."""
        is_folder = stat.S_ISDIR(status.st_mode)
        return cls(
            -1 if is_folder else status.st_size,
            status.st_mtime_ns,
            bool(status.st_mode & stat.S_IXUSR),
            '',
            status.st_ctime_ns,
            status.st_ino,
        )

    @property
    def is_settled(self) -> bool:
        """
        Whether any later change will show; to be asked at once.

        One within the same tick of the file system's clock would not.
        """
        now = time.time_ns()
        # a time in the far future is as good as one long ago
        return all(
            abs(now - moment) >= (TICK if moment % _SECOND else COARSE_TICK)
            for moment in (self.mtime, self.ctime)
        )


def fingerprint(path: str) -> Fingerprint | None:
    """
    Return the fingerprint of a file or folder, None when there is nothing.

    Links are followed; a dangling one is a file on its own.
    """
    try:
        return Fingerprint.of(os.stat(path))
    except OSError:
        try:
            return Fingerprint.of(os.lstat(path))
        except OSError:
            return None


def fingerprints(paths: Iterable[str]) -> dict[str, Fingerprint | None]:
    """Return the fingerprints of some paths."""
    return {path: fingerprint(path) for path in paths}


def are_settled(found: Iterable[Fingerprint | None]) -> bool:
    """Return whether any later change will show in all of them."""
    return all(one is None or one.is_settled for one in found)


def with_content(
    path: Path,
    now: Fingerprint,
    before: Fingerprint | None,
    limit: int | None = None,
) -> Fingerprint:
    """
    Return a fingerprint with the digest of the content.

    :param now: Its fingerprint, which was taken a moment ago
    :param before: An earlier one, whose digest is used again if it was not
      written since
    :param limit: As for :func:`content_digest`
    """
    is_settled = now.is_settled
    if before is not None and has_same_times(before, now):
        content = before.digest
    else:
        content = content_digest(path, now.size, limit)
    return now._replace(
        mtime=now.mtime if is_settled else 0, digest=content, inode=0
    )


def has_same_content(
    path: Path,
    before: Fingerprint,
    now: Fingerprint,
    limit: int | None = None,
) -> bool:
    """
    Return whether a file has the content that it had.

    One whose content is not known has another one as soon as any of its times
    differs, also that which no program can set.

    :param before: As :func:`with_content` returned it
    :param limit: As for :func:`content_digest`
    """
    if before.size != now.size:
        return False
    if has_same_times(before, now):
        return True
    if not before.digest:
        return False
    # a checkout there and back, or a copied workspace
    return before.digest == content_digest(path, now.size, limit)


def digest(content: bytes) -> str:
    """Return the digest of a content, as a hexadecimal number."""
    return blake2b(content, digest_size=_DIGEST_SIZE).hexdigest()


def content_digest(path: Path, size: int, limit: int | None = None) -> str:
    """
    Return the digest of a file; empty for a large or unreadable one.

    :param limit: How large it may be, by default :data:`READ_SIZE` (bytes)
    """
    if size > (READ_SIZE if limit is None else limit) or not os.path.isfile(
        path
    ):
        return ''
    found = blake2b(digest_size=_DIGEST_SIZE)
    try:
        with path.open('rb', buffering=0) as file:
            while data := file.read(_CHUNK):
                found.update(data)
    except OSError:
        return ''
    return found.hexdigest()


def has_same_times(before: Fingerprint, now: Fingerprint) -> bool:
    """Return whether a file cannot have been written in between."""
    return (before.size, before.mtime, before.ctime) == (
        now.size,
        now.mtime,
        now.ctime,
    )
