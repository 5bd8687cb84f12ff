# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Commands: requests to a running launch, and the responses to them.

A key, an option such as `--stop`, a request on the control socket, a watched
file, Ctrl-C and the launcher of a remote part all send these commands. Each
class has the name of its request in the control protocol as `name`;
`engine.dispatcher` has one handler for each. To add a command, add a class
here and a handler there; a response with fields of its own is also read in
`control.command_codec.response_of`.
"""

from typing import ClassVar, Generic, Literal, TYPE_CHECKING, TypeVar

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.plan.plan import Entry, Member

if TYPE_CHECKING:
    # few launches are asked for these
    from colcon_yamllaunch.engine.description import Branch, Description


# -- responses


@dataclass(frozen=True, slots=True)
class Done:
    """The command was executed, or its execution has begun."""


DONE = Done()


@dataclass(frozen=True, slots=True)
class Refused:
    """
    The command was refused.

    :param error: Why, in one line
    """

    error: str


@dataclass(frozen=True, slots=True)
class Described:
    """The response to `Describe`."""

    description: 'Description'


@dataclass(frozen=True, slots=True)
class PlanTree:
    """
    The response to `Tree`.

    :param tree: The launch files, groups, timers, processes and components
    """

    tree: 'tuple[Branch, ...]'


@dataclass(frozen=True, slots=True)
class Restarted:
    """
    The response to `RestartChanged`.

    :param labels: The processes and components that start again
    """

    labels: tuple[str, ...]


# -- commands

Response = TypeVar('Response', covariant=True)


class Command(Generic[Response]):
    """
    A request to a launch, which responds with a `Response` or `Refused`.

    :cvar name: Its name in the control protocol
    :cvar is_public: Whether any client of the control socket may send it;
      otherwise, only the launcher of a part that runs on a machine may
    """

    __slots__ = ()
    name: ClassVar[str]
    is_public: ClassVar[bool] = True


@dataclass(frozen=True, slots=True)
class MemberCommand(Command[Response]):
    """
    A command about one process or component.

    :param member: Its label, what ROS 2 calls the process, or the full name
      of the component's node
    """

    member: str


@dataclass(frozen=True, slots=True)
class Stop(MemberCommand[Done]):
    """
    Stop a process, or unload a component, and keep it so.

    The same command again takes the next step of stopping at once.
    """

    name: ClassVar[str] = 'stop'


@dataclass(frozen=True, slots=True)
class Restart(MemberCommand[Done]):
    """Stop a process and start it again, or reload a component."""

    name: ClassVar[str] = 'restart'


@dataclass(frozen=True, slots=True)
class Kill(MemberCommand[Done]):
    """End a process, and all that it started, by SIGKILL."""

    name: ClassVar[str] = 'kill'


@dataclass(frozen=True, slots=True)
class Debug(MemberCommand[Done]):
    """
    Restart a process under a debugger. Its next start is without it.

    :param port: The TCP port of this machine at which another program, such
      as an editor, can control the debugger: `debugpy` for a program in
      Python, else `gdbserver`. Without it, `pdb` or `gdb` waits for commands
      in a terminal
    """

    port: int | None = None
    name: ClassVar[str] = 'debug'


@dataclass(frozen=True, slots=True)
class Describe(MemberCommand[Described]):
    """Describe a process or component as the plan has it now."""

    name: ClassVar[str] = 'describe'


@dataclass(frozen=True, slots=True)
class ChangeState(MemberCommand[Done]):
    """
    Ask a lifecycle node for a transition.

    The response comes when the node has made it.

    :param transition: The transition; see `plan.TRANSITIONS`
    """

    transition: Literal[
        'configure', 'activate', 'deactivate', 'cleanup', 'shutdown'
    ]
    name: ClassVar[str] = 'change_state'


@dataclass(frozen=True, slots=True)
class Type(MemberCommand[Done]):
    """Type at the terminal of a process."""

    keys: bytes
    name: ClassVar[str] = 'type'
    is_public: ClassVar[bool] = False


@dataclass(frozen=True, slots=True)
class Tree(Command[PlanTree]):
    """Return the plan as a tree."""

    name: ClassVar[str] = 'tree'


@dataclass(frozen=True, slots=True)
class Watch(Command[Done]):
    """Pause or resume the consequences of changed files (`--watch`)."""

    action: Literal['pause', 'resume']
    name: ClassVar[str] = 'watch'


@dataclass(frozen=True, slots=True)
class Shutdown(Command[Done]):
    """
    Begin to stop everything; start nothing more.

    :param reason: Why, as a part of a sentence
    :param interactive: Whether a user at a keyboard asks for it, and can ask
      again
    :param drop_timers: Whether to drop the timers that outlast a shutdown
    """

    reason: str = 'requested'
    interactive: bool = False
    drop_timers: bool = True
    name: ClassVar[str] = 'shutdown'


@dataclass(frozen=True, slots=True)
class Escalate(Command[Done]):
    """Send the next signal of the stop sequence to everything at once."""

    name: ClassVar[str] = 'escalate'


@dataclass(frozen=True, slots=True)
class Hold(Command[Done]):
    """Suspend all processes as Ctrl-Z does, or let them go on."""

    is_held: bool
    name: ClassVar[str] = 'hold'
    is_public: ClassVar[bool] = False


@dataclass(frozen=True, slots=True)
class Resize(Command[Done]):
    """Set the size of the terminals of all processes."""

    columns: int
    lines: int
    name: ClassVar[str] = 'resize'
    is_public: ClassVar[bool] = False


# -- changes of the plan while it runs


@dataclass(frozen=True, slots=True)
class Extend(Command[Done]):
    """
    Add entries to the end of the plan.

    It is refused if a label is taken.
    """

    entries: tuple[Entry, ...]
    name: ClassVar[str] = 'extend'
    is_public: ClassVar[bool] = False


@dataclass(frozen=True, slots=True)
class Revise(Command[Done]):
    """
    Use another definition of a member from its next start on.

    :param member: The definition, with the label of a member of the plan
    :param at_once: Whether it would be started as the running one was, so
      that its `respawn`, `on_exit` and timeouts apply now
    """

    member: Member
    at_once: bool = False
    name: ClassVar[str] = 'revise'
    is_public: ClassVar[bool] = False


@dataclass(frozen=True, slots=True)
class RestartChanged(Command[Restarted]):
    """
    Restart processes and reload components after a change.

    A member that was stopped on request, or has not started yet, is left
    alone. Each starts when the one before it has started.
    """

    labels: tuple[str, ...]
    name: ClassVar[str] = 'restart_changed'
    is_public: ClassVar[bool] = False


@dataclass(frozen=True, slots=True)
class Drop(Command[Done]):
    """Stop or unload a member of the plan, and then forget it."""

    label: str
    name: ClassVar[str] = 'drop'
    is_public: ClassVar[bool] = False


@dataclass(frozen=True, slots=True)
class Forget(Command[Done]):
    """Remove entries from the plan that have not been executed yet."""

    entries: tuple[Entry, ...]
    name: ClassVar[str] = 'forget'
    is_public: ClassVar[bool] = False
