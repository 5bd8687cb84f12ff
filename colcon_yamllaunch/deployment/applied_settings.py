# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Gives the processes and components of a plan their settings."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
import os.path
from typing import Any

from colcon_yamllaunch.common.suggestions import did_you_mean
from colcon_yamllaunch.control.process_names import meant_by, ProcessNames
from colcon_yamllaunch.deployment.deployment import Deployment, Setting
from colcon_yamllaunch.deployment.process_settings import (
    COMPONENT_SETTINGS,
    LIMITS,
    Pattern,
    PROCESS_CONDITIONS,
)
from colcon_yamllaunch.language.syntax.diagnostics import (
    Diagnostic,
    LaunchError,
)
from colcon_yamllaunch.plan.member_settings import (
    MemberSettings,
    ResourceLimits,
    ROS_KINDS,
    SettingPlace,
)
from colcon_yamllaunch.plan.plan import (
    AfterReady,
    changed_entries,
    Component,
    Entry,
    Member,
    Plan,
    Process,
    Timer,
)
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.plan.ros_names import names_of, needs_node_name
from colcon_yamllaunch.plan.start_order import cycle_in, dependencies_of


class AppliedSettings:
    """
    Applies the settings of a deployment to a plan, also to later entries.

    :param deployment: Its rules set something
    """

    def __init__(self, deployment: Deployment) -> None:
        self._rules = [rule for rule in deployment.rules if rule.settings]
        # all processes and components so far, with their settings
        self._known: dict[str, Member] = {}

    def apply(self, plan: Plan) -> Plan:
        """
        Return a plan with the settings.

        :param plan: It has the names of machines in its labels
        :raises LaunchError: when processes would wait for what is not there,
          or for one another
        """
        if not self._rules:
            return plan
        members: list[Member] = [*plan.processes(), *plan.components()]
        self._known |= {member.label: member for member in members}
        resolver = _SettingsResolver(
            self._settings_of(members),
            list(self._known.values()),
            may_grow=plan.worker_position is not None,
        )
        found = {
            member.label: resolver.with_settings(member) for member in members
        }
        self._known |= found
        problems = [*self._misplaced(), *resolver.problems]
        if problems:
            raise LaunchError(*problems)
        self._check_cycles()
        entries = changed_entries(
            plan.entries,
            lambda entry: (
                found[entry.label] if isinstance(entry, Member) else entry
            ),
        )
        return replace(plan, entries=tuple(_in_start_order(entries)))

    def _settings_of(
        self, members: Sequence[Member]
    ) -> dict[str, dict[str, Setting]]:
        """Return the settings by label; for each key, the first rule wins."""
        found: dict[str, dict[str, Setting]] = {p.label: {} for p in members}
        for rule in self._rules:
            for index in rule.selected(members):
                given = found[members[index].label]
                for key, setting in rule.settings.items():
                    given.setdefault(key, setting)
        return found

    def _misplaced(self) -> Iterator[Diagnostic]:
        """Find rules that set for components what only a process can have."""
        known = list(self._known.values())
        for rule in self._rules:
            selected = [known[index] for index in rule.selected(known)]
            components = [m for m in selected if isinstance(m, Component)]
            if not components or len(components) < len(selected):
                continue
            for key, setting in rule.settings.items():
                if key not in COMPONENT_SETTINGS:
                    yield Diagnostic(
                        'error',
                        f"'{key}' is a setting of a process, and '{rule}' "
                        'matches only components',
                        setting.position,
                        'set it for their container, which all of its '
                        f'components share: {components[0].container}',
                        setting.length,
                    )

    def _check_cycles(self) -> None:
        cycle = cycle_in(dependencies_of(self._known.values()))
        if not cycle:
            return
        settings = self._known[cycle[0]].settings
        raise LaunchError(
            Diagnostic(
                'error',
                f'these wait for one another: {" → ".join(cycle)}',
                None if settings is None else settings.position,
                "remove one of these names from its 'after'",
                len('after'),
            )
        )


class _SettingsResolver:
    """
    Gives members their settings, and collects what is wrong with these.

    :param given: The settings by label and key
    :param known: The members that names in settings may refer to
    :param may_grow: Whether more processes may come later
    """

    def __init__(
        self,
        given: Mapping[str, Mapping[str, Setting]],
        known: Sequence[Member],
        *,
        may_grow: bool,
    ) -> None:
        self._given = given
        self._labels = [member.label for member in known]
        self._names = [ProcessNames.of_plan(member) for member in known]
        self._may_grow = may_grow
        self._problems: dict[Pattern | Position | str, Diagnostic] = {}

    @property
    def problems(self) -> Iterable[Diagnostic]:
        """What is wrong, each problem once."""
        return self._problems.values()

    def with_settings(self, member: Member) -> Member:
        """Return a process or component with its settings."""
        given = self._given[member.label]
        if isinstance(member, Component):
            given = {k: s for k, s in given.items() if k in COMPONENT_SETTINGS}
        if not given:
            return member
        fields = {key: setting.value for key, setting in given.items()}
        if isinstance(member, Process):
            member = _changed_process(member, fields)
        if 'ready' in given and isinstance(member, Process):
            self._check_names(member, given['ready'])
        elif 'ready' in given and isinstance(member, Component):
            self._check_component(member, given['ready'])
        return replace(
            member, settings=self._settings(member.label, given, fields)
        )

    def _check_names(self, process: Process, ready: Setting) -> None:
        """Report conditions about a node whose name is not known."""
        if names_of(process).node:
            return
        for condition in ready.value:
            if condition.kind in ('lifecycle', 'parameter') or (
                condition.kind in ROS_KINDS and needs_node_name(condition.name)
            ):
                self._problems[process.label] = Diagnostic(
                    'error',
                    f'{process.label} cannot be checked for {condition}, as '
                    'the launch file does not name its node',
                    ready.position,
                    "give the node a 'name' in the launch file",
                    ready.length,
                )

    def _check_component(self, component: Component, ready: Setting) -> None:
        """Report conditions that only a process can meet."""
        for condition in ready.value:
            if condition.kind in PROCESS_CONDITIONS:
                self._problems[ready.position] = Diagnostic(
                    'error',
                    f"{component.label} is a component: '{condition.kind}' "
                    'is a condition of processes',
                    ready.position,
                    'set it for the container of the component, '
                    f'{component.container}',
                    ready.length,
                )

    def _settings(
        self,
        label: str,
        given: Mapping[str, Setting],
        fields: dict[str, Any],
    ) -> MemberSettings:
        at = given.get('after') or next(iter(given.values()))
        if 'after' in fields:
            fields['after'] = self._labels_of(label, fields['after'])
        if 'restart' in fields:
            restart, together = fields['restart']
            others = self._labels_of(label, together)
            fields['restart'] = replace(restart, together=others)
        limits = {key: fields.pop(key) for key in LIMITS if key in fields}
        return MemberSettings(
            at.position,
            limits=ResourceLimits(**limits) if limits else None,
            places=tuple(
                SettingPlace(key, given[key].position)
                for key in (*LIMITS, 'user')
                if key in given
            ),
            **fields,
        )

    def _labels_of(
        self, label: str, patterns: Iterable[Pattern]
    ) -> tuple[str, ...]:
        """
        Return the labels of the members that names and globs match.

        :param label: The member whose settings have them
        """
        found: dict[str, None] = {}
        for pattern in patterns:
            labels = [
                self._labels[i] for i in meant_by(pattern.text, self._names)
            ]
            if labels == [label]:
                # a rule for several processes may name one of them
                continue
            if label in labels:
                others = (
                    ', '.join(n for n in labels if n != label) or 'nothing'
                )
                self._fail(
                    pattern,
                    f"'{pattern.text}' includes {label} itself",
                    f'name the others: {others}',
                )
            elif not labels and not self._may_grow:
                self._fail(
                    pattern,
                    f'no process or component of the launch is called '
                    f"'{pattern.text}'",
                    did_you_mean(pattern.text, self._labels)
                    or 'the names of all are shown by --plan',
                )
            found |= dict.fromkeys(labels)
        return tuple(found)

    def _fail(self, pattern: Pattern, message: str, hint: str) -> None:
        self._problems[pattern] = Diagnostic(
            'error', message, pattern.position, hint, pattern.length
        )


def _changed_process(process: Process, fields: dict[str, Any]) -> Process:
    """Return a process with the variables, folder and output that are set."""
    environment = dict(process.environment) | dict(fields.pop('env', ()))
    directory = fields.pop('directory', process.cwd)
    if directory.startswith('~'):
        # that of its user
        directory = f'~{fields.get("user", "")}{directory[1:]}'
    return replace(
        process,
        environment=tuple(sorted(environment.items())),
        cwd=os.path.expanduser(directory),
        output=fields.pop('output', process.output),
    )


def _in_start_order(entries: Iterable[Entry]) -> Iterator[Entry]:
    """
    Put members that wait for others into `AfterReady` entries.

    A timer of the launch file starts to count when the others are ready. So a
    member leaves its timer, and gets one of its own with the same time.
    """
    for entry in entries:
        if isinstance(entry, Timer):
            rest = []
            for inner in _in_start_order(entry.entries):
                if isinstance(inner, AfterReady):
                    delayed = replace(entry, entries=inner.entries)
                    yield replace(inner, entries=(delayed,))
                else:
                    rest.append(inner)
            if rest or not entry.entries:
                yield replace(entry, entries=tuple(rest))
        elif (
            isinstance(entry, Member)
            and entry.settings is not None
            and entry.settings.after
        ):
            yield AfterReady(entry.settings.after, (entry,))
        else:
            yield entry
