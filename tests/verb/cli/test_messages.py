# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

from collections.abc import Callable
import errno
import io
import os

from colcon_yamllaunch.common.errors import OutputError
from colcon_yamllaunch.common.messages import (
    ForgivingOutput,
    say,
    show,
    show_bytes,
)
from colcon_yamllaunch.verb.options_verb import report_errors
import pytest

pytestmark = pytest.mark.hostile


class Failing(io.TextIOWrapper):
    """A stream that takes nothing."""

    def __init__(self, number: int) -> None:
        super().__init__(io.BytesIO())
        self._number = number

    def write(self, text: str) -> int:
        raise OSError(self._number, os.strerror(self._number))

    def flush(self) -> None:
        raise OSError(self._number, os.strerror(self._number))


@pytest.mark.parametrize('number', [errno.ENOSPC, errno.EFBIG, errno.EBADF])
@pytest.mark.parametrize(
    'action',
    [lambda: show('text'), lambda: show_bytes(b'text'), lambda: None],
)
def test_one_error_says_what_is_wrong(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    number: int,
    action: Callable[[], None],
) -> None:
    monkeypatch.setattr('sys.stdout', Failing(number))
    assert report_errors('launch', lambda: action() or 0) == 1
    assert capsys.readouterr().err == (
        'colcon launch: error: the output cannot be written: '
        f'{os.strerror(number)}\n'
    )


def test_nobody_who_reads_is_no_error(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr('sys.stdout', Failing(errno.EPIPE))

    def action() -> int:
        show('text')
        return 0

    assert report_errors('launch', action) == 1
    assert capsys.readouterr().err == ''


def test_what_cannot_be_said_is_left_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr('sys.stderr', Failing(errno.ENOSPC))
    monkeypatch.setattr('sys.stdout', Failing(errno.ENOSPC))
    say('text')
    with pytest.raises(OutputError, match='No space left'):
        show('text')


def test_colcon_may_write_where_nothing_is_taken() -> None:
    output = ForgivingOutput(Failing(errno.ENOSPC))
    assert output.write('text') == 4
    output.flush()
    assert output.encoding == Failing(errno.ENOSPC).encoding


@pytest.mark.parametrize(
    ('number', 'file', 'fix'),
    [
        (errno.EMFILE, None, 'ulimit -n 1024'),
        (errno.ENOENT, '/dev/null', 'mknod -m 666 /dev/null c 1 3'),
    ],
)
def test_lack_of_the_system_is_no_internal_error(
    capsys: pytest.CaptureFixture[str],
    number: int,
    file: str | None,
    fix: str,
) -> None:
    def action() -> int:
        raise OSError(number, os.strerror(number), file)

    assert report_errors('launch', action) == 1
    said = capsys.readouterr().err
    assert said.startswith('colcon launch: error: ')
    assert f'help: {fix}' in said
