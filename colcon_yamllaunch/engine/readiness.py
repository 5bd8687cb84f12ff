# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Finds out which processes and components are ready.

Only launches whose plan has settings for that import this. The conditions of
a member are checked on its machine, see :mod:`.ready_checks`; what waits for
it is held back in :mod:`.held_entries`.
"""

from collections.abc import Iterable, Mapping
from functools import partial

from colcon_yamllaunch.common.frozen import mutable
from colcon_yamllaunch.engine import events, limits
from colcon_yamllaunch.engine.engine import Engine
from colcon_yamllaunch.engine.loop import TimerHandle
from colcon_yamllaunch.engine.participants import Participant
from colcon_yamllaunch.engine.ready_checks import CHECKS, ReadyCheck
from colcon_yamllaunch.plan.member_settings import (
    READY_TIMEOUT,
    ReadyCondition,
    ROS_KINDS,
)
from colcon_yamllaunch.plan.plan import Member, Plan, Process

# what a member without conditions of its own must meet
_DEFAULT = ReadyCondition('running')
_ACTIVE = ReadyCondition('lifecycle', 'active')


def needs_readiness(plan: Plan) -> bool:
    """Return whether it matters for a plan which members are ready."""
    return any(
        member.settings is not None
        and (member.settings.ready or member.settings.after)
        for member in plan.members()
    )


@mutable
class _Start:
    """
    A start of a member that is not ready yet.

    :param time: When it was, by the clock of the loop
    :param checks: The checks of conditions that do not hold yet
    :param timer: Reports that the member is not ready in time
    :param found: What there is instead, by check, while a report waits for
      that
    """

    member: Member
    time: float
    checks: list[ReadyCheck]
    timer: TimerHandle
    found: dict[ReadyCheck, str] | None = None


class Readiness(Participant):
    """
    Emits `Ready` and `NotReady` for the members of a launch.

    :param after: For each member the labels that it waits for
    """

    _engine: Engine

    def __init__(self, after: Mapping[str, tuple[str, ...]]) -> None:
        self._after = after
        # the starts whose conditions hold, with the time of that
        self._ready: list[tuple[_Start, float]] = []
        self._starts: dict[str, _Start] = {}
        # the labels of members that the ROS client has checked
        self._seen_in_ros: set[str] = set()
        # the labels of those of which other conditions are unmet
        self._changed: set[str] = set()

    def join(self, engine: Engine) -> None:
        """Note that the launch knows what is ready."""
        self._engine = engine
        engine.state.has_readiness = True
        engine.state.after = dict(self._after)

    def begin(self) -> None:
        """Start a ROS client if a member is checked in the ROS graph."""
        self._expect(self._engine.planned_processes())

    def handle(self, event: events.Event) -> None:
        """Begin checks of a member when it starts; end them when it ends."""
        match event:
            case events.Planned(members=members):
                self._expect(members)
                self._revise(members)
            case events.Started(process=process):
                self._begin(process)
            case events.Loaded(component=component):
                self._begin(component)
            case events.StateChanged(member=member):
                self._pass_on(member, event)
            case events.Exited() | events.StartFailed():
                process = event.process
                again = event.respawn_delay is not None
                if not isinstance(event, events.Exited) or event.failed:
                    # one that has done its work is ready all the same
                    self._ready = [
                        (start, seconds)
                        for start, seconds in self._ready
                        if start.member.label != process.label
                    ]
                self._end(process, is_final=not again)
                self._forget(process)
            case events.LoadFailed(component=component, again=again):
                self._end(component, is_final=not again)
            case events.Unloaded(component=component):
                self._end(component, is_final=False)
                self._forget(component)
            case events.ShuttingDown():
                self.close()
            case _:
                pass

    def handle_output(self, event: events.Output) -> None:
        """Pass output on to the checks that search it."""
        self._pass_on(event.process, event)

    def end_turn(self) -> None:
        """Report what is ready, after all other events of the turn."""
        ready, self._ready = self._ready, []
        for start, seconds in ready:
            self._engine.emit(events.Ready(start.member, seconds))
        changed, self._changed = self._changed, set()
        for label in changed & self._starts.keys():
            start = self._starts[label]
            unmet = tuple(str(check.condition) for check in start.checks)
            self._engine.emit(events.MemberChanged(start.member, unmet=unmet))

    def close(self) -> None:
        """End all checks."""
        for label in list(self._starts):
            self._cancel(label)

    def _revise(self, members: Iterable[Member]) -> None:
        """Check the conditions that members have now, unless they are met."""
        for member in members:
            start = self._starts.get(member.label)
            if start is not None and start.member != member:
                self._begin(member, start.time)

    def _begin(self, member: Member, begun: float | None = None) -> None:
        """
        Begin to check a member.

        :param begun: When it started, by default now
        """
        self._cancel(member.label)
        loop, settings = self._engine.loop, member.settings
        if self._engine.state.machine_of(member.label) is not None:
            # that machine finds it out
            return
        timeout = READY_TIMEOUT
        if settings is not None:
            timeout = settings.ready_timeout
        start = _Start(
            member,
            loop.time() if begun is None else begun,
            [],
            loop.call_later(timeout, self._late, member.label),
        )
        self._starts[member.label] = start
        start.checks = [
            self._check_class(member, condition)(
                self._engine, member, condition, partial(self._met, start)
            )
            for condition in self._conditions_of(member)
        ]
        self._changed.add(member.label)
        for check in tuple(start.checks):
            check.begin()
        loop.wake()

    def _expect(self, members: Iterable[Member]) -> None:
        """
        Start a ROS client if members are nodes that other members wait for.

        Without ROS in the environment, they are ready when they run.
        """
        machine_of = self._engine.state.machine_of
        if any(
            self._is_default_node(member) and machine_of(member.label) is None
            for member in members
        ):
            self._engine.use_ros()

    def _is_default_node(self, member: Member) -> bool:
        """Return whether a member is ready when its node is in the graph."""
        if member.node_name is None or not isinstance(member, Process):
            return False
        if member.settings is not None:
            return not (member.settings.ready or member.autostart)
        return not member.autostart and any(
            member.label in labels
            for labels in self._engine.state.after.values()
        )

    def _conditions_of(self, member: Member) -> tuple[ReadyCondition, ...]:
        if member.settings is not None and member.settings.ready:
            return member.settings.ready
        if member.autostart:
            return (_ACTIVE,)
        has_ros = self._engine.composition is not None
        if has_ros and self._is_default_node(member):
            from colcon_yamllaunch.engine import ros_ready_checks

            return (ros_ready_checks.node_condition(member),)
        return (_DEFAULT,)

    def _check_class(
        self, member: Member, condition: ReadyCondition
    ) -> type[ReadyCheck]:
        if condition.kind not in ROS_KINDS:
            return CHECKS[condition.kind]
        from colcon_yamllaunch.engine import ros_ready_checks

        self._seen_in_ros.add(member.label)
        return ros_ready_checks.check_of(member, condition)

    def _forget(self, member: Member) -> None:
        """Let the ROS client ignore what remains of a member that ended."""
        composition = self._engine.composition
        if composition is not None and member.label in self._seen_in_ros:
            composition.requests.gone(member=member.label)

    def _met(self, start: _Start, check: ReadyCheck) -> None:
        if check not in start.checks:
            return
        start.checks.remove(check)
        check.cancel()
        self._changed.add(start.member.label)
        if not start.checks:
            self._cancel(start.member.label)
            now = self._engine.loop.time()
            self._ready.append((start, now - start.time))
            self._engine.loop.wake()

    def _pass_on(self, member: Member, event: events.Event) -> None:
        start = self._starts.get(member.label)
        for check in () if start is None else tuple(start.checks):
            check.handle(event)

    def _late(self, label: str) -> None:
        start = self._starts[label]
        start.found = {}
        start.timer = self._engine.loop.call_later(
            limits.EXPLANATION_TIMEOUT, self._report_late, start
        )
        for check in tuple(start.checks):
            check.explain(partial(self._explained, start, check))

    def _explained(self, start: _Start, check: ReadyCheck, text: str) -> None:
        """Note what exists instead of what a check waits for."""
        if start.found is None:
            return
        start.found[check] = text
        if all(other in start.found for other in start.checks):
            self._report_late(start)

    def _report_late(self, start: _Start) -> None:
        found, start.found = start.found, None
        if found is None or self._starts.get(start.member.label) is not start:
            return
        start.timer.cancel()
        conditions = tuple(str(check.condition) for check in start.checks)
        texts = dict.fromkeys(found.get(check, '') for check in start.checks)
        self._report(start, conditions, '; '.join(filter(None, texts)))

    def _end(self, member: Member, *, is_final: bool) -> None:
        """
        Handle the end of a member.

        :param is_final: Whether it does not start again by itself
        """
        start = self._starts.get(member.label)
        self._cancel(member.label)
        if start is not None and is_final and self._waiting_for(member):
            self._report(start, ())

    def _report(
        self, start: _Start, conditions: tuple[str, ...], found: str = ''
    ) -> None:
        engine, member = self._engine, start.member
        settings = member.settings
        action = 'warn' if settings is None else settings.on_timeout
        seconds = engine.loop.time() - start.time
        waiting = self._waiting_for(member)
        engine.emit(
            events.NotReady(
                member, conditions, action, seconds, found, waiting
            )
        )
        if action == 'fail':
            engine.supervisor.stop(f'{member.label} is not ready')

    def _waiting_for(self, member: Member) -> tuple[str, ...]:
        """Return the labels of the members that wait for a member."""
        return tuple(
            other.label
            for other in self._engine.state.members()
            if member.label in other.waits_for
        )

    def _cancel(self, label: str) -> None:
        start = self._starts.pop(label, None)
        if start is not None:
            start.timer.cancel()
            for check in start.checks:
                check.cancel()
