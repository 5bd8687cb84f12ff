# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Whether a package is built, why, and how much of its last build stays."""

from enum import IntEnum

from colcon_yamllaunch.common.frozen import dataclass


class BuildMode(IntEnum):
    """
    How a package is built; each mode does what those before it do, too.

    Build tools compare times and keep answers from earlier runs. Where this
    could give another outcome than a build from scratch, less is kept.
    """

    #: What the build tool finds changed, which is nothing but compiled code.
    COMPILE = 0
    #: What the build tool finds changed.
    BUILD = 1
    #: CMake is asked anew; what was compiled stays.
    CONFIGURE = 2
    #: What was installed is removed before.
    REINSTALL = 3
    #: What was built is removed, too.
    CLEAN = 4


@dataclass(frozen=True, slots=True)
class Reason:
    """
    A reason to build.

    :param text: Such as `src/flow.cpp changed`
    :param mode: What it takes
    :param is_damage: Whether what was built is not as it was built
    """

    text: str
    mode: BuildMode = BuildMode.BUILD
    is_damage: bool = False


@dataclass(frozen=True, slots=True)
class Decision:
    """
    What is to be done with a package.

    :param reasons: Why it is built, the most telling one first; none if it is
      up to date
    :param built_at: When it was last built successfully, as far as is known
      (nanoseconds since the epoch)
    """

    name: str
    reasons: tuple[Reason, ...] = ()
    built_at: int | None = None

    @property
    def is_stale(self) -> bool:
        """Whether the package is built."""
        return bool(self.reasons)

    @property
    def reason(self) -> str:
        """The first reason."""
        return self.reasons[0].text if self.reasons else ''

    @property
    def mode(self) -> BuildMode:
        """How it is built."""
        return max((r.mode for r in self.reasons), default=BuildMode.COMPILE)
