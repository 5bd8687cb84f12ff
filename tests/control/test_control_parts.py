# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The parts of the control socket that need no launch."""

from contextlib import suppress
import os
from pathlib import Path
import shutil
import socket
import tempfile

from colcon_yamllaunch.common import files as common_files
from colcon_yamllaunch.control import protocol, socket_folder
from colcon_yamllaunch.control.protocol import ProtocolError
from colcon_yamllaunch.control.socket_folder import (
    Address,
    connections,
    FolderError,
    folders,
    is_own,
    is_permitted,
    open_folder,
    readable_folders,
    services_of_others,
)
from colcon_yamllaunch.engine.state import (
    from_json,
    MachineState,
    StateError,
    to_json,
)
from hypothesis import given, strategies
import pytest
from support.hostile import needs_other_user, OTHER_USER
from support.launch_states import component_state, launch_state, process_state


@pytest.fixture
def place(tmp_path):
    """Return an environment whose sockets are in a folder of the test."""
    runtime = tmp_path / 'run'
    runtime.mkdir(mode=0o700)
    return {'XDG_RUNTIME_DIR': str(runtime), 'TMPDIR': str(tmp_path)}


def test_runtime_folder_comes_first(place, tmp_path):
    fallback = tmp_path / f'colcon-launch-{os.getuid()}'
    first = Path(place['XDG_RUNTIME_DIR']) / 'colcon-launch'
    assert folders(place) == (first, fallback)


@pytest.mark.hostile
def test_both_terminals_try_the_same_places(place, tmp_path, monkeypatch):
    users = tmp_path / 'users'
    runtime = users / str(os.getuid())
    runtime.mkdir(parents=True, mode=0o700)
    monkeypatch.setattr(socket_folder, 'USER_FOLDERS', str(users))
    monkeypatch.setattr(
        common_files, 'SHARED_FOLDERS', (str(tmp_path / 'shared'),)
    )
    with_variables = {'XDG_RUNTIME_DIR': str(runtime), 'TMPDIR': '/far/away'}
    for one, other in ((with_variables, {}), ({}, with_variables)):
        address = Address(one)
        (connection,) = connections(other, pytest.fail)
        connection.close()
        address.close()
    # without a login there is no folder of the user's own
    shutil.rmtree(runtime)
    (tmp_path / 'shared').mkdir()
    address = Address({})
    (connection,) = connections({'TMPDIR': '/far/away'}, pytest.fail)
    connection.close()
    # who has a runtime folder of his own is apart
    assert connections(place, pytest.fail) == []
    address.close()


@pytest.mark.hostile
def test_a_socket_is_never_in_the_current_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(common_files, 'SHARED_FOLDERS', ('/not/there',))
    for folder in ('.', '', '/does/not/exist'):
        with pytest.raises(FolderError, match='colcon-launch') as caught:
            Address({'TMPDIR': folder, 'XDG_RUNTIME_DIR': folder})
        assert '\n' not in str(caught.value)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.hostile
@pytest.mark.parametrize('way', ['open', 'file', 'link'])
def test_a_bad_folder_does_not_block_the_others(place, tmp_path, way):
    first, second = folders(place)
    if way == 'open':
        first.mkdir()
        first.chmod(0o755)
    elif way == 'file':
        first.write_text('in the way')
    else:
        first.symlink_to(tmp_path)
    address = Address(place)
    assert address.path.parent == second
    (trouble,) = address.troubles
    assert str(first) in trouble
    warned = []
    (connection,) = connections(place, warned.append)
    connection.close()
    address.close()
    assert warned == [trouble]


@pytest.mark.parametrize('runtime', ['', 'relative', '/does/not/exist'])
def test_invalid_runtime_folder_is_not_used(runtime, tmp_path):
    place = {'XDG_RUNTIME_DIR': runtime, 'TMPDIR': str(tmp_path)}
    assert [f.parent for f in folders(place)] == [tmp_path]


def test_shared_runtime_folder_is_not_used(place, tmp_path):
    Path(place['XDG_RUNTIME_DIR']).chmod(0o777)
    assert [f.parent for f in folders(place)] == [tmp_path]


@pytest.mark.parametrize(
    ('mode', 'owner', 'problem'),
    [
        (0o755, None, 'chmod 700'),
        pytest.param(
            *(0o700, 12345, 'not yours alone'),
            marks=pytest.mark.skipif(
                os.getuid() != 0, reason='needs root to give files away'
            ),
        ),
    ],
)
def test_folder_that_is_not_private_is_refused(tmp_path, mode, owner, problem):
    folder = tmp_path / 'open'
    folder.mkdir()
    folder.chmod(mode)
    if owner:
        os.chown(folder, owner, owner)
    with pytest.raises(FolderError, match=problem):
        open_folder(folder, make=True)


def test_link_is_not_followed(tmp_path):
    (tmp_path / 'elsewhere').mkdir(mode=0o700)
    (tmp_path / 'link').symlink_to(tmp_path / 'elsewhere')
    with pytest.raises(FolderError, match='link'):
        open_folder(tmp_path / 'link', make=True)


@needs_other_user
def test_another_user_is_not_listened_to(place):
    address = Address(place)
    # where others may come in, as into no folder of a launch
    with socket.socket(socket.AF_UNIX) as reachable:
        reachable.bind('')
        reachable.listen()
        for user in (os.getuid(), OTHER_USER):
            pid = os.fork()
            if pid == 0:
                os._exit(_connect_as(user, reachable, address))
            connection, _ = reachable.accept()
            assert is_own(connection) == (user == os.getuid())
            connection.close()
            refused = os.waitpid(pid, 0)[1]
            assert bool(refused) == (user == OTHER_USER)
    address.close()


def _connect_as(user, reachable, address):
    """Return 0 where a user can connect to a launch."""
    code = 1
    with suppress(BaseException):
        # a whole path may be too long for a socket
        os.chdir(address.path.parent)
        os.setuid(user)
        with socket.socket(socket.AF_UNIX) as connection:
            connection.connect(reachable.getsockname())
        with socket.socket(socket.AF_UNIX) as connection:
            connection.connect(address.path.name)
        code = 0
    return code


def test_socket_in_a_folder_with_a_long_path_is_found(tmp_path):
    deep = tmp_path / ('x' * 120)
    deep.mkdir(mode=0o700)
    place = {'XDG_RUNTIME_DIR': str(deep), 'TMPDIR': str(tmp_path)}
    address = Address(place)
    (connection,) = connections(place, pytest.fail)
    connection.close()
    address.close()


def test_stale_sockets_are_removed_and_other_files_stay(place, monkeypatch):
    folder = Path(place['XDG_RUNTIME_DIR']) / 'colcon-launch'
    folder.mkdir(mode=0o700)
    # a whole path may be too long for a socket
    monkeypatch.chdir(folder)
    for name in ('123.sock', '4194305.sock.new'):
        stale = socket.socket(socket.AF_UNIX)
        stale.bind(name)
        stale.close()
    (folder / '5.sock').write_text('a file')
    (folder / 'note').write_text('a note')
    assert connections(place, pytest.fail) == []
    assert sorted(p.name for p in folder.iterdir()) == ['5.sock', 'note']


@given(strategies.binary())
def test_any_line_is_decoded_or_refused(line):
    with suppress(ProtocolError):
        assert isinstance(protocol.decode(line), dict)


@given(strategies.binary())
def test_every_byte_survives_the_protocol(data):
    message = {'output': protocol.text_of(data)}
    line = protocol.encode(message)
    assert line.count(b'\n') == 1
    assert protocol.bytes_of(protocol.decode(line)['output']) == data


@pytest.mark.parametrize('text', [7, None, '€'])
def test_text_that_is_not_bytes_is_refused(text):
    with pytest.raises(ProtocolError):
        protocol.bytes_of(text)


def a_launch():
    return launch_state(
        process_state('a-1', pid=7, restarts=2, node='/a', log='/log'),
        component_state('b', 'a-1', lifecycle='active', log='/log'),
        machines={'arm': MachineState('arm', 'lost', 'no answer')},
        clock=lambda: 5.0,
    )


def read(data):
    return to_json(from_json(data, lambda: 5.0))


def test_state_survives_json():
    data = to_json(a_launch())
    sent = protocol.decode(protocol.encode(data))
    assert read({**sent, 'later': 'addition'}) == data


def test_a_client_knows_what_waits_for_what():
    launch = a_launch()
    launch.has_readiness, launch.after = True, {'a': (), 'b': ('a',)}
    client = from_json(protocol.decode(protocol.encode(to_json(launch))))
    assert client.has_readiness
    assert list(client.after['b']) == ['a']


def test_state_of_an_older_launch_lacks_fields():
    data = to_json(a_launch())
    assert data['processes'][0].pop('name') is None
    del data['processes'][0]['condition'], data['processes'][0]['lifecycle']
    del data['components']
    state = from_json(data)
    (a,) = state.processes
    assert (a.name, a.condition, a.lifecycle) == (None, 'running', None)
    assert state.components == []


@pytest.mark.parametrize('missing', ['pid', 'processes', 'phase', 'plugin'])
def test_incomplete_state_is_refused(missing):
    data = to_json(a_launch())
    data['processes'][0].pop(missing, None)
    data['components'][0].pop(missing, None)
    data.pop(missing, None)
    with pytest.raises(StateError):
        from_json(data)


@pytest.fixture
def service_folder(tmp_path, monkeypatch):
    """Return the folder that systemd makes for a service of another user."""
    # others can reach it
    monkeypatch.chdir('/')
    top = Path(tempfile.mkdtemp(dir='/tmp'))
    top.chmod(0o755)
    folder = top / 'my_robot'
    folder.mkdir(mode=0o700)
    monkeypatch.setattr(socket_folder, 'SERVICE_FOLDERS', top)
    yield folder
    shutil.rmtree(top)


def test_service_has_its_socket_in_its_own_folder(place, service_folder):
    service = {**place, 'RUNTIME_DIRECTORY': str(service_folder)}
    address = Address(service)
    assert address.path.parent == service_folder
    (connection,) = connections(place, pytest.fail)
    connection.close()
    address.close()
    # such a folder of other services is not used
    other = {**place, 'RUNTIME_DIRECTORY': '/run/other'}
    assert folders(other) == folders(place)


@needs_other_user
def test_root_finds_services_of_others_and_they_answer(place, service_folder):
    os.chown(service_folder, OTHER_USER, OTHER_USER)
    read, write = os.pipe()
    pid = os.fork()
    if pid == 0:
        os.close(read)
        os._exit(_serve_once(service_folder, write))
    os.close(write)
    assert os.read(read, 1) == b'!'
    (connection,) = connections(place, pytest.fail)
    assert is_permitted(connection) is False
    assert connection.recv(1) == b'1'
    connection.close()
    os.close(read)
    assert os.waitpid(pid, 0)[1] == 0
    # this user makes no socket among those of others
    assert service_folder not in folders(place)


def _serve_once(folder, ready):
    """Accept a client as another user; return 0 unless this fails."""
    with suppress(BaseException):
        os.setgid(OTHER_USER)
        os.setuid(OTHER_USER)
        address = Address({'RUNTIME_DIRECTORY': str(folder)})
        os.write(ready, b'!')
        address.socket.setblocking(True)
        client, _ = address.socket.accept()
        client.send(b'1' if is_permitted(client) else b'0')
        client.close()
        address.close()
        return 0
    return 1


@needs_other_user
def test_others_learn_that_a_service_runs_and_no_more(place, service_folder):
    pid = os.fork()
    if pid == 0:
        code = 1
        with suppress(BaseException):
            os.setuid(OTHER_USER)
            found = services_of_others()
            hidden = service_folder not in readable_folders({})
            code = 0 if found == {'my_robot': 0} and hidden else 1
        os._exit(code)
    assert os.waitpid(pid, 0)[1] == 0
    assert services_of_others() == {}
