# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""`colcon launch --watch`, with processes that really run."""

from collections import Counter
import os
from pathlib import Path
import shutil
import signal
from types import SimpleNamespace

from colcon_yamllaunch.verb.watch_launch import prepare_again
from colcon_yamllaunch.watch.preparer import Failed
import pytest
from support.manifest import manifest
from support.waiting import is_running, wait_until
from support.watched import make_flow, Watched

BROKEN, MENDED = "printt('talk says three", "print('talk says two"
MORE_OF_IT = '- executable: {cmd: sleep 999, name: further}\n'

#: Saves the parameter file of a script, as it is, while that starts.
AWAY = """\
import os, sys
if os.path.exists('{flag}'):
    os.remove('{flag}')
    os.rename('{file}', '{file}~')
    print('talk found nothing', flush=True)
    os.rename('{file}~', '{file}')
    sys.exit(1)
"""


#: A package in which nothing is compiled.
CMAKE = """\
cmake_minimum_required(VERSION 3.16)
project(flow NONE)
install(PROGRAMS node.py DESTINATION lib/flow)
install(FILES words.py DESTINATION lib/flow)
install(FILES demo.yaml view.rviz DESTINATION share/flow)
"""
NODE = """\
#!/usr/bin/env python3
import signal, words
signal.signal(signal.SIGINT, lambda *_: exit(0))
print('node says', words.WORD, flush=True)
while True: signal.pause()
"""
DEMO = """\
launch:
- node: {pkg: flow, exec: node.py, name: node}
- executable:
    cmd: sh -c 'echo view; exec sleep 1000' $(find-pkg-share flow)/view.rviz
    name: view
- executable: {cmd: sleep 1000, name: other}
"""


@pytest.fixture
def flow(user):
    make_flow(user)
    return user


def test_each_change_has_only_its_consequence(flow):
    w = Watched(flow).watches()
    counts = Counter({'talk': 1, 'loop': 1, 'other': 1, 'more-4': 1})

    def expect(line, *labels):
        w.says(rf'\[watch\] +{line} \(\d+\.\d\d s\)')
        counts.update(labels)
        assert w.starts() == counts

    # a script that is linked: nothing is built
    w.save('scripts/talk.py', 'says one', 'says two')
    expect('talk.py changed: restarted talk', 'talk')
    w.says('talk says two')
    # a library that is mapped into one of two programs
    w.save('src/word.c', '"one"', '"two"')
    expect('word.c changed: built flow, restarted loop', 'loop')
    w.says('loop says two')
    # a program
    w.save('src/other.c', '"one"', '"two"')
    expect('other.c changed: built flow, restarted other', 'other')
    w.says('other says two')
    # a parameter file
    w.save('config/talk.yaml', '1', '2')
    expect('talk.yaml changed: restarted talk', 'talk')
    w.says('value: 2')
    # a launch file: what is new, gone and different
    w.save('launch/demo.yaml', 'name: talk\n', 'name: talk\n    args: more\n')
    expect('demo.yaml changed: restarted talk', 'talk')
    w.save('launch/more.yaml', 'more}\n', f'more}}\n{MORE_OF_IT}')
    expect('more.yaml changed: started further-5', 'further-5')
    w.save('launch/more.yaml', MORE_OF_IT, '')
    expect('more.yaml changed: stopped further-5')
    # a launch file with a mistake, and the cure
    before = w.running()
    w.save('launch/demo.yaml', 'exec: loop', 'exec: lop')
    w.says("error: .*'lop'")
    expect('demo.yaml changed: it cannot be launched so, .* as before')
    w.save('launch/demo.yaml', 'exec: lop', 'exec: loop')
    expect('demo.yaml changed: nothing that runs differs')
    # a build that fails, and the cure
    w.save('src/word.c', 'return', 'retrun')
    w.says('word.c:1:.*error')
    expect('word.c changed: the build failed, .* as before')
    assert w.running() == before
    # what was missing when the build failed comes back
    script = flow.root / 'src/flow/scripts/talk.py'
    script.rename(script.with_name('kept'))
    w.says(r'\[watch\] +.*talk.py.* as before')
    script.with_name('kept').rename(script)
    w.says(r'\[watch\] +.*talk.py.* as before.*\n(.*\n)*.*talk.py.*as before')
    w.save('src/word.c', 'retrun "two"', 'return "six"')
    line = 'word.c changed: built flow, restarted talk, loop'
    expect(line, 'talk', 'loop')
    w.says('loop says six')
    # whatever the exit code: others may have been killed on this machine
    status = flow.start('colcon', 'launch', '--status')
    status.wait_for(line)
    assert w.launch.interrupt() == 0
    kinds = ('changed', 'built', 'replanned', 'restarted')
    assert {e['event'] for e in w.events(*kinds)} == set(kinds)
    assert 'Traceback' not in w.launch.output


def test_linked_modules_and_files_need_no_build(user):
    user.write('src/flow/package.xml', manifest('flow', 'cmake'))
    user.write('src/flow/CMakeLists.txt', CMAKE)
    user.write('src/flow/node.py', NODE, 0o755)
    user.write('src/flow/words.py', "WORD = 'one'\n")
    user.write('src/flow/view.rviz', 'from above')
    user.write('src/flow/demo.yaml', DEMO)
    w = Watched(user)
    w.says('node says one')
    w.says('view-2.* view')
    w.save('words.py', 'one', 'three')
    w.says(r'\[watch\] +words.py changed: restarted node \(')
    w.says('node says three')
    w.save('view.rviz', 'above', 'below')
    w.says(r'\[watch\] +view.rviz changed: restarted view-2 \(')
    assert w.starts() == Counter({'node': 2, 'view-2': 2, 'other-3': 1})
    assert not w.events('built')
    assert w.launch.interrupt() == 0


def test_mistakes_stop_nothing_that_runs(flow):
    w = Watched(flow).watches()
    before = w.running()
    w.save(
        'scripts/talk.py', "print('talk says one'", "print('talk says two'("
    )
    w.says(r'src/flow/scripts/talk.py:5:\d+: error: ')
    w.says(r'talk.py changed: not restarted, as Python code does not compile')
    assert w.running() == before
    w.save('scripts/talk.py', "two'(", "two'")
    w.says('talk says two')
    # a launch that begins now would build what is gone
    shutil.rmtree(flow.root / 'install')
    w.save('scripts/talk.py', 'says two', 'says three')
    w.says(r'talk.py changed: built flow, restarted talk')
    w.says('talk says three')
    w.save('scripts/talk.py', 'import signal', 'exit(1)\nimport signal')
    w.says(r'talk.py changed: failed once started: talk \(')
    assert w.launch.interrupt() == 1


def test_removed_workspace_is_no_internal_error(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    cwd = tmp_path / 'ws'
    answer = prepare_again(SimpleNamespace(cwd=cwd), (), print)
    assert answer == Failed('plan')
    assert capsys.readouterr().err == (
        f'colcon launch: error: there is no {cwd} any more, in which the '
        'launch was begun: restore it, or launch elsewhere\n'
    )


def test_process_that_read_a_file_during_its_save_restarts(flow):
    w = Watched(flow).watches()
    # what starts finds its parameter file away, which comes back as it was
    w.save('scripts/talk.py', 'says one', 'says two')
    w.says('talk.py changed: restarted talk')
    w.says('talk says two')
    # what runs has read it, or else failed
    w.save('scripts/talk.py', 'says two', 'says two')
    w.save('config/talk.yaml', '1', '2')
    w.says('talk.yaml changed: restarted talk')
    w.says('talk says two value: 2')
    assert w.starts()['talk'] == 3
    assert 'saved again' not in w.launch.output
    flag, file = flow.root / 'flag', flow.root / 'src/flow/config/talk.yaml'
    flag.touch()
    away = AWAY.format(flag=flag, file=file)
    w.save('scripts/talk.py', 'import signal', f'{away}import signal')
    w.says('talk found nothing')
    w.says(r'\[watch\] +talk.yaml saved again: restarted talk')
    w.says('talk says two value: 2')
    assert w.launch.interrupt() == 0


def test_build_ends_with_a_killed_launcher(flow):
    w = Watched(flow).watches()
    before = w.running()
    slow = 'execute_process(COMMAND sleep 1000)\n'
    w.save('CMakeLists.txt', 'add_library', f'{slow}add_library')
    w.says('building 1 package')
    launcher = w.launch.process.pid
    # that of the build beside the one of the launch
    wait_until(lambda: len(_children_of(launcher, 'sleep')) == 2)
    pids = _descendants(launcher)
    assert pids.issuperset(before.values())
    os.kill(launcher, signal.SIGKILL)
    wait_until(lambda: not any(map(is_running, pids)))


def test_change_during_a_build_restarts_it(flow):
    flow.write('src/flow/launch/unused.yaml', 'launch: []')
    w = Watched(flow, '--why').watches()
    slow = 'execute_process(COMMAND sleep 1000)\n'
    w.save('CMakeLists.txt', 'add_library', f'{slow}add_library')
    w.says('building 1 package')
    # a file that is saved as it was is no change
    w.save('src/word.c', 'one', 'one')
    w.save('launch/unused.yaml', 'launch', '# launch')
    w.says('unused.yaml changed: nothing to do')
    assert w.launch.output.count('changed: building') == 1
    assert 'saved again' not in w.launch.output
    w.save('src/word.c', '"one"', '"two"')
    w.says('word.c.* changed: building 1 package')
    # what it misses while it is built may come out as it was
    os.kill(w.running()['other'], signal.SIGKILL)
    w.says('other: .*SIGKILL')
    w.save('CMakeLists.txt', slow, '')
    w.says(r'\[watch\] .*word.c.* changed: built flow, restarted loop, other')
    w.says('loop says two')
    assert w.launch.interrupt() == 0


def test_check_follows_each_change(flow):
    w = Watched(flow, '--until', 'talk says (one|two)', '--until', 'loop says')
    w.says(r'\[watch\] +green: all was seen')
    w.save('scripts/talk.py', 'says one', 'says three')
    w.says('talk says three')
    w.save('scripts/talk.py', 'print(', 'printt(')
    w.says(
        r'\[watch\] +red: talk exited with code 1, '
        r"'talk says \(one\|two\)' was not seen"
    )
    w.save('scripts/talk.py', BROKEN, MENDED)
    w.says(r'\[watch\] +green: all was seen')
    assert w.launch.interrupt() == 0


def _descendants(pid):
    found, pending = set(), [pid]
    while pending:
        parent = pending.pop()
        try:
            path = Path(f'/proc/{parent}/task/{parent}/children')
            children = {int(word) for word in path.read_text().split()}
        except FileNotFoundError:
            continue
        pending += children
        found |= children
    return found


def _children_of(pid, name):
    found = set()
    for child in _descendants(pid):
        try:
            comm = Path(f'/proc/{child}/comm').read_text().strip()
        except (FileNotFoundError, ProcessLookupError):
            continue
        if comm == name:
            found.add(child)
    return found
