# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The full screen, typed at as a user does, without a launch."""

from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
import re
from typing import Any

from colcon_yamllaunch.control.subscription import LostData
from colcon_yamllaunch.engine.commands import Debug, Kill, Restart, Stop, Watch
from colcon_yamllaunch.engine.description import Branch
from colcon_yamllaunch.engine.events import ChangeReported
from colcon_yamllaunch.terminal.full_screen.launch_screen import (
    LaunchApp,
    LaunchScreen,
)
from colcon_yamllaunch.terminal.full_screen.widgets import MemberList
from colcon_yamllaunch.terminal.keymap import ON_ALL, ON_ONE
from rich.style import Style
from support.shown_launch import (
    component,
    exited,
    happened,
    process,
    ShownLaunch,
    state_of,
    wrote,
)
from support.shown_screen import Around, run_app, Shown


def play(
    launch: ShownLaunch,
    act: Callable[[Shown], Awaitable[Any]],
    around: Around | None = None,
    size: tuple[int, int] = (100, 24),
) -> LaunchApp:
    """Run the app for a launch that exists on the screen only."""
    app = LaunchApp(launch, around or Around(), lambda _: {})

    @contextmanager
    def suspend() -> Iterator[None]:
        yield

    app.suspend = suspend  # type: ignore[method-assign]
    run_app(app, act, size)
    return app


def test_each_key_has_an_effect() -> None:
    for key in (*ON_ONE, *ON_ALL):
        by_itself = key.command or key.filter
        assert by_itself or hasattr(LaunchScreen, f'key_{key.name}')


def test_keys_send_commands_for_the_row_of_the_cursor() -> None:
    launch = ShownLaunch(
        process('kitchen'), process('box'), component('talker', 'box')
    )
    around = Around()

    async def act(shown: Shown) -> None:
        await shown.shows('1 ● kitchen', '2 ● box', '● talker')
        await shown.types('s', 'down', 'r', 'down', 'k', '1', 'd')
        await shown.until(lambda: len(launch.commands) == 4)
        assert launch.commands == [
            Stop('kitchen'),
            Restart('box'),
            Kill('talker'),
            Debug('kitchen'),
        ]
        launch.refused = 'there is no debugger'
        await shown.types('d')
        await shown.shows('there is no debugger')
        await shown.types('i')
        await shown.shows("talker 'a b'", 'rate: 5', 'ROLE unset')
        await shown.types('escape', 'a')
        await shown.shows('kitchen has no terminal; emulate_tty or --tty')
        await shown.types('l')
        await shown.until(lambda: around.asked == ['page /log/kitchen.log'])
        launch.state = ShownLaunch(process('kitchen', terminal=True)).state
        launch.emit(happened('started', 'kitchen', pid=7))
        await shown.hides('talker')
        await shown.types('a')
        await shown.until(lambda: around.asked[1:] == ['attach kitchen'])
        await shown.types('q')

    app = play(launch, act, around)
    assert not app.is_running


def test_filter_keys_select_the_output() -> None:
    launch = ShownLaunch(process('kitchen'), process('hall'))

    async def act(shown: Shown) -> None:
        launch.emit(
            wrote('kitchen', 'warm', '[ERROR] [1.2] [kitchen]: hot'),
            wrote('hall', 'Cold'),
        )
        await shown.shows('[kitchen] warm', '[kitchen] [ERROR]', '[hall] Cold')
        await shown.types('o')
        await shown.hides('Cold')
        await shown.types('o', 'm')
        await shown.hides('warm')
        await shown.shows('Cold', '1 muted', '(muted)')
        await shown.types('m', 'L', 'L')
        await shown.hides('warm')
        await shown.shows('hot', 'level WARN')
        await shown.types('escape', 't')
        await shown.shows('warm', '.000 [kitchen]')
        await shown.types('M')
        await shown.hides('warm')
        await shown.types('M', '2', 'space')
        await shown.shows('Cold', 'only hall')

    play(launch, act)


def test_keys_typed_into_the_prompt_are_text() -> None:
    launch = ShownLaunch(process('kitchen'), process('hall'))

    async def act(shown: Shown) -> None:
        launch.emit(wrote('kitchen', 'a skill', 'warm'))
        await shown.shows('warm')
        # in one go, as they come by a slow line
        for key in ('/', 's', 'k', 'i'):
            shown.app.simulate_key('slash' if key == '/' else key)
        await shown.hides('warm')
        await shown.shows('a skill', '/ski', 'Enter keeps what is found')
        await shown.hides('s stop')
        await shown.types('enter', 'slash', 'x')
        await shown.hides('a skill')
        await shown.types('escape')
        await shown.shows('a skill')
        await shown.types('escape')
        await shown.shows('warm')
        await shown.types('colon', 'a', 'l', 'enter', 's')
        await shown.until(lambda: launch.commands == [Stop('hall')])

    play(launch, act)


def test_failed_process_is_found_among_many() -> None:
    nodes = [process(f'node{number}') for number in range(200)]
    launch = ShownLaunch(*nodes)

    async def act(shown: Shown) -> None:
        await shown.shows('node0', '0 ● node9')
        down = {'phase': 'ended', 'condition': 'failed', 'pid': None}
        nodes[150] = process('node150', ending='died', failure='X', **down)
        launch.state = ShownLaunch(*nodes).state
        launch.emit(exited('node150', 3))
        await shown.shows('1 failed')
        await shown.types('f')
        await shown.shows('✗ node150', 'died')
        launch.state = ShownLaunch(*nodes[100:]).state
        launch.tree = (Branch('process', 'node150', 'x:1:1'),)
        launch.emit(happened('dropped', 'node0'))
        await shown.types('p')
        await shown.hides('node151')
        await shown.shows('✗ node150')

    play(launch, act)


def test_narrow_terminal_shows_one_pane() -> None:
    launch = ShownLaunch(process('kitchen'))

    async def act(shown: Shown) -> None:
        launch.emit(wrote('kitchen', 'warm'))
        await shown.shows('● kitchen', 'Tab switch', 'q leave')
        assert 'warm' not in shown.text
        await shown.types('tab')
        await shown.shows('[kitchen] warm')
        assert '●' not in shown.text
        await shown.pilot.resize_terminal(100, 24)
        await shown.shows('● kitchen', 'warm')
        await shown.types('question_mark')
        await shown.shows('kill it with all')
        await shown.pilot.resize_terminal(40, 24)
        # what goes on in the next line does so below its like
        await shown.shows('(emulate_tty,')
        assert re.search(r'│ {9,}\(?\w+.*\n', shown.text)

    play(launch, act, size=(40, 10))


def test_scrolled_output_stays_until_end_is_in_sight() -> None:
    launch = ShownLaunch(process('kitchen'))

    async def act(shown: Shown) -> None:
        launch.emit(wrote('kitchen', *(f'line {n}.' for n in range(100))))
        await shown.shows('line 99.')
        await shown.types('tab', 'home')
        await shown.shows('line 0.', 'held')
        launch.emit(wrote('kitchen', 'line 100.'))
        await shown.until(lambda: len(shown.app.panes.model.view.lines) == 101)
        assert 'line 100.' not in shown.text
        await shown.types('end')
        await shown.shows('line 100.')
        await shown.hides('held')
        launch.emit(wrote('kitchen', 'line 101.'))
        await shown.shows('line 101.')

    play(launch, act)


def test_output_can_be_read_after_the_end() -> None:
    launch = ShownLaunch(process('kitchen'))
    around = Around(owns_launch=True)

    async def act(shown: Shown) -> None:
        await shown.types('q')
        await shown.shows('leave it running')
        launch.emit(wrote('kitchen', 'warm'), exited('kitchen', 3))
        launch.emit(happened('ended', exit_code=1))
        failed = {'phase': 'ended', 'pid': None, 'failure': 'exit 3'}
        members = [process('kitchen', condition='failed', **failed)]
        launch.state = state_of(*members, exit_code=1)
        launch.end()
        await shown.shows('ended, exit code 1', '1 failed', 'q leaves')
        await shown.types('s')
        await shown.shows('the launch has ended')
        await shown.types('slash', 'w', 'enter')
        await shown.shows('warm')
        await shown.types('q')

    app = play(launch, act, around)
    assert not app.is_running
    assert around.asked == []


def test_owned_launch_is_stopped_on_request() -> None:
    launch = ShownLaunch(process('kitchen'))
    around = Around(owns_launch=True)

    async def act(shown: Shown) -> None:
        await shown.types('ctrl+c')
        await shown.shows('Ctrl-C again to force')
        await shown.types('q', 'escape', 'q')
        await shown.shows('leave it running')
        await shown.types('s')
        await shown.until(lambda: around.asked == ['interrupt'] * 2)
        assert shown.app.is_running
        launch.end()
        await shown.until(lambda: not shown.app.is_running)

    play(launch, act, around)


def test_resized_output_stays_at_the_same_line() -> None:
    launch = ShownLaunch(process('kitchen'))

    async def act(shown: Shown) -> None:
        await shown.types('tab')
        launch.emit(
            wrote('kitchen', *(f'{n}. {"-" * 50} end{n}.' for n in range(99)))
        )
        await shown.shows('98. ---', '-- end98.')
        await shown.types('pageup', 'pageup', 'pageup')
        await shown.hides('98.')
        first = re.findall(r'end\d+', shown.text)[0]
        # what is in the first row stays near, whatever becomes of the rest
        await shown.pilot.resize_terminal(100, 10)
        await shown.types('t', 'slash', '-')
        await shown.shows('.000 ', ' /- ', first)
        await shown.types('escape', 'end')
        await shown.shows('end98.')

    play(launch, act, size=(40, 10))


def test_watch_key_switches_watch() -> None:
    launch = ShownLaunch(process('kitchen'))

    async def act(shown: Shown) -> None:
        await shown.shows('q leave')
        assert 'w watch' not in shown.text
        await shown.types('w')
        await shown.shows('no files are watched; that is --watch')
        for action, paused in (('pause', True), ('resume', False)):
            said = {'watch': 'all is new', 'watch_paused': paused}
            before = {**said, 'watch_paused': not paused}
            launch.state = state_of(process('kitchen'), **before)
            launch.emit(happened('watched', text='all is new'))
            await shown.shows(
                'watch: all is new' if paused else ' --watch is off '
            )
            await shown.types('w')
            await shown.shows('is off: w switches' if paused else 'is on')
            await shown.until(
                lambda action=action: Watch(action) in launch.commands
            )

    play(launch, act, size=(120, 24))


def test_only_shown_output_is_read_after_a_gap() -> None:
    launch = ShownLaunch(process('kitchen'), process('hall'))

    def wanted() -> list[Any]:
        asked = [one[1] for one in launch.asked if isinstance(one, tuple)]
        return [more['processes'] for more in asked]

    async def act(shown: Shown) -> None:
        launch.emit(LostData(0, 1 << 20))
        await shown.shows('1.0 MiB not shown')
        await shown.types('o')
        await shown.shows('only kitchen')
        assert wanted() == []
        launch.emit(LostData(0, 1 << 20))
        await shown.until(lambda: wanted() == [['kitchen']])
        await shown.shows('of what is not shown, nothing is read')
        await shown.types('m')
        await shown.until(lambda: wanted()[1:] == [[]])
        await shown.types('escape')
        await shown.until(lambda: wanted()[2:] == [None])

    play(launch, act)


def test_process_keys_are_refused_for_components() -> None:
    launch = ShownLaunch(process('box'), component('talker', 'box'))

    async def act(shown: Shown) -> None:
        await shown.shows('s stop', 'k kill', 'o only')
        assert 'a attach' not in shown.text
        await shown.types('down')
        await shown.hides('k kill')
        assert 's stop' in shown.text
        await shown.types('a')
        await shown.shows('talker is a component: it has no keyboard')
        await shown.types('1', 'M', 'space')
        # who is chosen is not muted
        await shown.shows('only box', '● box')
        assert 'muted' not in shown.text
        await shown.types('escape')
        for key in ('m', 'o', 'space'):
            await shown.types('down', key)
            await shown.shows('talker is a component: its container writes')
            await shown.types('1', 'f')
            await shown.shows('nothing has failed')

    play(launch, act)


def test_cursor_row_has_one_style() -> None:
    launch = ShownLaunch(
        process('kitchen', phase='ended', condition='failed', ending='exit 3'),
        process('box'),
    )

    async def act(shown: Shown) -> None:
        await shown.shows('1 ✗ kitchen', 'exit 3')
        strip = shown.app.panes.query_one(MemberList).render_line(0)
        styles = {segment.style for segment in strip if segment.text}
        assert styles == {Style(reverse=True)}

    play(launch, act)


def test_errors_of_a_build_can_be_shown_again() -> None:
    launch = ShownLaunch(process('kitchen'))

    async def act(shown: Shown) -> None:
        await shown.types('E')
        await shown.shows('no build has failed')
        text = 'pump.cpp changed: the build failed'
        errors = [text, 'pump.cpp:39:1: error']
        launch.state.apply(
            ChangeReported(text, failed=True, details=errors[1])
        )
        launch.emit(happened('watched', text=text, errors=errors))
        launch.emit(happened('watched', text='b.py changed: restarted b'))
        await shown.shows('restarted b')
        await shown.types('E')
        await shown.shows(*errors)
        await shown.types('E')
        await shown.hides('pump.cpp:39:1: error')

    play(launch, act)
