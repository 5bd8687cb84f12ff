# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Components and lifecycle nodes of a running launch, by name."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.control.client import ControlError, LaunchEndedError
from colcon_yamllaunch.control.selection import Candidate
from colcon_yamllaunch.engine.commands import ChangeState, MemberCommand
from colcon_yamllaunch.engine.state import (
    About,
    ComponentState,
    LaunchState,
    MemberState,
    ProcessState,
)
from colcon_yamllaunch.terminal import client_attachment
from colcon_yamllaunch.verb import (
    controlling,
    process_candidates,
    reading_logs,
)
from colcon_yamllaunch.verb.completing import Cursor
from colcon_yamllaunch.verb.options import Completer, LaunchOptions
import pytest
from support.launch_states import component_state, launch_state, process_state


def process(label: str, **more: Any) -> ProcessState:
    known = {
        'pid': 7,
        'executable': label.rstrip('-0123456789'),
        'log': f'/log/{label}',
    }
    return process_state(label, **{**known, **more})


def component(label: str, **more: Any) -> ComponentState:
    known = {'node': f'/ns/{label}', 'log': '/log/box-1'}
    return component_state(label, **{**known, **more})


#: `/far` is a container of somebody else.
LAUNCH = launch_state(
    process('box-1', node='/box'),
    process('camera-2', node='/ns/camera', lifecycle='unconfigured'),
    component('talker'),
    component('mapper', lifecycle='inactive', plugin='demo::Mapper'),
    component('remote', container='/far', process=None, log=None),
    about=About('demo', None, '/demo.yaml', '/'),
)


class FakeLaunch:
    """A running launch that does what it is asked at once, if it may."""

    def __init__(self) -> None:
        self.state = LAUNCH
        self.requests: list[tuple[str, ...]] = []
        self.refused: dict[str, str] = {}
        self.after: dict[str, dict[str, Any]] = {}

    def do(
        self,
        command: MemberCommand[Any],
        waiting: Callable[[], None] | None = None,
    ) -> None:
        label = command.member
        more = [command.transition] if isinstance(command, ChangeState) else []
        self.requests.append((command.name, label, *more))
        if waiting is not None:
            waiting()
        if label in self.refused:
            raise ControlError(self.refused[label])
        members = map(self._changed, self.state.by_label.values())
        by_label = {member.label: member for member in members}
        self.state = replace(self.state, by_label=by_label)

    def refresh(self) -> LaunchState:
        return self.state

    def _changed(self, member: Any) -> Any:
        return replace(member, **self.after.get(member.label, {}))


@pytest.fixture
def running(monkeypatch: pytest.MonkeyPatch) -> FakeLaunch:
    """Return the one launch that runs."""
    launch = FakeLaunch()

    def find(*_: object) -> list[Candidate]:
        return [Candidate(launch, launch.state)]  # type: ignore[arg-type]

    monkeypatch.setattr(controlling, 'find_launches', find)
    monkeypatch.setattr(
        process_candidates, '_running', lambda _: [launch.state]
    )
    return launch


def ask(action: str, *names: str, **more: Any) -> int:
    return controlling.control(
        LaunchOptions(request=action, names=names, **more), {}
    )


@pytest.mark.parametrize(
    ('name', 'meant'),
    [
        ('talker', ['talker']),
        ('/ns/talker', ['talker']),
        ('demo::Mapper', ['mapper']),
        ('demo::*', ['talker', 'mapper', 'remote']),
        ('/ns', ['talker', 'mapper', 'camera-2', 'remote']),
        ('box', ['box-1']),
        # a container takes its components with it
        ('*', ['box-1', 'camera-2', 'remote']),
    ],
)
def test_names_of_components(
    running: FakeLaunch, name: str, meant: list[str]
) -> None:
    for label in ('talker', 'mapper', 'remote'):
        running.after[label] = {'phase': 'unloaded'}
    running.after['camera-2'] = {'phase': 'ended', 'ending': 'stopped'}
    ask('stop', name)
    assert running.requests == [('stop', label) for label in meant]


def test_an_unknown_component_names_the_nearest(running: FakeLaunch) -> None:
    with pytest.raises(UserError) as error:
        ask('stop', 'taker')
    assert str(error.value) == (
        "demo has no process or component 'taker': did you mean 'talker'?"
    )
    assert not running.requests


def test_a_component_is_unloaded_and_loaded_anew(
    running: FakeLaunch, capsys: pytest.CaptureFixture[str]
) -> None:
    running.after['talker'] = {'phase': 'unloaded'}
    assert ask('stop', 'talker') == 0
    running.after['talker'] = {'phase': 'loaded'}
    running.after['remote'] = {'phase': 'failed', 'ending': 'no such class'}
    assert ask('restart', 'talker', 'remote') == 1
    assert capsys.readouterr().err.splitlines() == [
        'talker: unloaded',
        'talker: loaded anew into box-1',
        'remote: could not be loaded: no such class',
    ]


def test_what_cannot_be_unloaded_is_said(
    running: FakeLaunch, capsys: pytest.CaptureFixture[str]
) -> None:
    reason = 'could not be unloaded: busy'
    running.after['talker'] = {'ending': reason}
    assert ask('stop', 'talker') == 1
    assert ask('restart', 'talker') == 1
    assert capsys.readouterr().err == f'talker: {reason}\n' * 2


def test_one_that_is_refused_does_not_keep_others_from_it(
    running: FakeLaunch, capsys: pytest.CaptureFixture[str]
) -> None:
    running.refused['talker'] = 'talker is not loaded'
    running.after['mapper'] = {'phase': 'unloaded'}
    assert ask('stop', 'talker', 'mapper') == 1
    assert capsys.readouterr().err.splitlines() == [
        'demo: talker is not loaded',
        'mapper: unloaded',
    ]
    with pytest.raises(UserError, match='demo: talker is not loaded'):
        ask('stop', 'talker')


def test_a_container_of_others_is_not_waited_for(
    running: FakeLaunch,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(controlling, 'PROGRESS_INTERVAL', 0.0)
    running.after['remote'] = {'phase': 'waiting'}
    assert ask('restart', 'remote') == 1
    assert capsys.readouterr().err == (
        'remote: waits for the container /far\n'
    )


def test_a_container_brings_its_components_back(
    running: FakeLaunch, capsys: pytest.CaptureFixture[str]
) -> None:
    running.after['box-1'] = {'pid': 8}
    running.after['mapper'] = {'phase': 'failed', 'ending': 'no map'}
    assert ask('restart', 'box') == 1
    assert running.requests == [('restart', 'box-1')]
    assert capsys.readouterr().err.splitlines() == [
        'box-1: started anew, pid 8',
        'talker: loaded anew into box-1',
        'mapper: could not be loaded: no map',
    ]


def test_logs_of_a_component_are_its_containers(
    running: FakeLaunch, monkeypatch: pytest.MonkeyPatch
) -> None:
    shown: list[str | None] = []

    def show(_: object, members: list[MemberState], **__: object) -> int:
        shown.extend(p.label for p in members)
        return 0

    monkeypatch.setattr(reading_logs, 'show_logs', show)
    ask('logs', 'talker', 'mapper')
    ask('logs', '/ns/mapper', 'camera')
    ask('logs')
    assert shown == ['box-1', *('box-1', 'camera-2') * 2]
    with pytest.raises(UserError) as error:
        ask('logs', 'remote')
    assert str(error.value) == (
        'remote is in /far, which is no container of demo'
    )
    assert not running.requests


def test_a_component_has_no_keyboard(running: FakeLaunch) -> None:
    with pytest.raises(UserError, match='its container box-1'):
        client_attachment.attach(
            Candidate(running, LAUNCH),  # type: ignore[arg-type]
            LAUNCH.components[:1],
        )


def test_a_transition_says_the_new_state(
    running: FakeLaunch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert ask('lifecycle', 'mapper', transition='activate') == 0
    assert running.requests == [('change_state', 'mapper', 'activate')]
    assert capsys.readouterr().err.splitlines() == [
        'waiting for mapper',
        'mapper: active',
    ]
    # what has no lifecycle is not meant by a pattern
    running.requests.clear()
    assert ask('lifecycle', '*', '/ns', transition='shutdown') == 0
    assert [request[1] for request in running.requests] == [
        'mapper',
        'camera-2',
    ]


def test_a_transition_that_fails_says_what_is_possible(
    running: FakeLaunch, capsys: pytest.CaptureFixture[str]
) -> None:
    running.refused = {'mapper': 'no map', 'camera-2': 'it has no such'}
    assert ask('lifecycle', 'mapper', 'camera', transition='activate') == 1
    shown = capsys.readouterr().err.splitlines()
    assert 'mapper: activate failed: no map' in shown
    assert shown[-1] == (
        'camera-2: activate failed: it has no such; it could configure or '
        'shutdown'
    )


def test_what_has_no_lifecycle_is_refused(running: FakeLaunch) -> None:
    with pytest.raises(UserError) as error:
        ask('lifecycle', 'talker', transition='activate')
    assert str(error.value) == (
        'talker of demo is no lifecycle_node or composable_lifecycle_node; '
        'there is camera-2, mapper'
    )
    with pytest.raises(UserError, match="'mappr': did you mean 'mapper'"):
        ask('lifecycle', 'mappr', transition='activate')
    assert not running.requests


def test_completion_offers_components(running: FakeLaunch) -> None:
    def offered(
        completer: Completer, *words: str, prefix: str = ''
    ) -> dict[str, str]:
        cursor = Cursor(prefix, None, None, {})
        found = process_candidates.candidates_of(cursor, completer, words)
        return dict(found)

    assert set(offered('members')) == {
        *('box', 'camera', 'mapper', 'remote', 'talker'),
    }
    assert '/ns/talker' in offered('members', prefix='/ns/t')
    assert offered('lifecycles') == {
        'camera': 'running, unconfigured in demo',
        'mapper': 'loaded, inactive in demo',
    }
    found = offered('lifecycles', 'mapper')
    assert list(found) == ['activate', 'cleanup', 'shutdown']
    for words in (['talker'], ['mapper', 'activate']):
        assert not offered('lifecycles', *words)
    mapper = component('mapper', lifecycle='unknown')
    by_label = {**LAUNCH.by_label, 'mapper': mapper}
    running.state = replace(LAUNCH, by_label=by_label)
    assert len(offered('lifecycles', 'mapper')) == 5


def test_the_launch_may_end_meanwhile(
    running: FakeLaunch, monkeypatch: pytest.MonkeyPatch
) -> None:
    def end(*_: object, **__: object) -> None:
        raise LaunchEndedError

    monkeypatch.setattr(running, 'do', end)
    for action, more in (('lifecycle', 'shutdown'), ('stop', '')):
        with pytest.raises(UserError, match='demo: the launch has ended'):
            ask(action, 'mapper', transition=more)


def test_a_launch_that_refuses_holds_up_no_other(
    running: FakeLaunch,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    refusing = FakeLaunch()
    refusing.refused['box-1'] = 'the whole launch is being stopped'
    candidates = [
        Candidate(launch, launch.state)  # type: ignore[arg-type]
        for launch in (refusing, running)
    ]
    monkeypatch.setattr(controlling, 'find_launches', lambda *_: candidates)
    assert ask('restart', 'box-1', of='*') == 1
    assert running.requests == [('restart', 'box-1')]
    said = capsys.readouterr()
    assert 'error: demo: the whole launch is being stopped' in said.err
    assert 'box-1: started anew' in said.out + said.err
