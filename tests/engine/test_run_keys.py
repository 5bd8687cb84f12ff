# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What is on the screen after each key."""

import os
import sys

#: Writes the lines of a file that the test makes, and so again.
TELLER = (
    'import os, sys, time\n'
    'folder = os.environ["TMPDIR"]\n'
    'for n in range(99):\n'
    '    path = f"{folder}/lines{n}"\n'
    '    while not os.path.exists(path): time.sleep(0.02)\n'
    '    data = open(path, "rb").read()\n'
    '    sys.stdout.buffer.write(data); sys.stdout.flush()\n'
)
#: Asks for names, then for a secret, then for keys.
ASKER = (
    'import os, sys, termios, tty\n'
    'for n in range(2): print("hello", input("Name: "), flush=True)\n'
    'modes = termios.tcgetattr(0)\n'
    'modes[3] &= ~termios.ECHO\n'
    'termios.tcsetattr(0, termios.TCSANOW, modes)\n'
    'print(len(input("Secret: ")), "letters", flush=True)\n'
    'tty.setraw(0)\n'
    'print("raw", flush=True)\n'
    'while (key := os.read(0, 9)) != b"q": print(key, flush=True)\n'
)
#: Asks on standard error, then takes keys as ncurses does, which sets the
#: modes of the terminal that it writes to.
DRAWER = (
    'import os, sys, tty\n'
    'print("Name: ", end="", file=sys.stderr, flush=True)\n'
    'print("hello", sys.stdin.readline().strip(), flush=True)\n'
    'tty.setraw(1)\n'
    'while (key := os.read(0, 9)) != b"q": print(key, flush=True)\n'
)
#: Shows a file until a line is typed.
PAGER = (
    'import sys\n'
    'print("paging", open(sys.argv[1]).readline(), flush=True)\n'
    'input()\n'
)


class Teller:
    """What a process writes that the test has in its hands."""

    def __init__(self, one, label='t'):
        self.one = one
        self.label = label
        self.number = 0

    def writes(self, text):
        folder = self.one.launch.folder
        path = folder / 'lines'
        path.write_text(text)
        path.rename(folder / f'lines{self.number}')
        self.number += 1
        return self.one

    def has_logged(self, text):
        """Wait until something has been read, and left out of the screen."""
        label = self.one.launch.log_folder / self.label
        log = label / 'stdout_stderr.log'
        self.one.screen.shows(lambda _: text.encode() in log.read_bytes())
        return self.one


def test_the_keys_of_one_process(status, python, sleep):
    one = status(python('teller', TELLER), sleep('b'), size=(90, 24))
    teller = Teller(one, 'teller')
    teller.writes('a line\n').shows('[teller] a line', ' 1 ● teller  2 ● b')
    one.types('1').shows(' 1 ● teller  2 ● b', ' s stop  r restart  k kill')
    one.types('m').shows(' 1 ● (teller)  2 ● b', ' 1 muted')
    teller.writes('unseen\n')
    teller.has_logged('unseen')
    one.types('2o').shows(' 1 ● (teller)  2 ● b', ' only b, 1 muted')
    one.types('2o').shows(' 1 ● (teller)  2 ● b', ' 1 muted')
    one.types('1m').shows('[teller] a line', ' 1 ● teller  2 ● b')
    teller.writes('seen\n').shows('[teller] seen', ' 1 ● teller  2 ● b')
    one.types('2s').shows(' 1 ● teller  2 ■ b')
    one.types('2r').shows(' 1 ● teller  2 ● b ×1')
    one.types(':B\r').shows(' 1 ● teller  2 ● b ×1', ' s stop')
    one.types('k').shows(' 1 ● teller  2 ■ b ×1')
    one.types('1a').shows(' 1 ● teller  2 ■ b ×1', ' teller has no term')
    one.types('2a').shows(' 1 ● teller  2 ■ b ×1', ' b does not run')
    one.types('2i')
    one.screen.shows(lambda lines: '  command: sleep 999' in lines)
    one.types('?').shows('  Ctrl-]  go back', '  Esc goes back')
    one.types('q').shows(' 1 ● teller  2 ■ b ×1')
    one.types('w').shows(' 1 ● teller  2 ■ b ×1', ' no files are watched')
    one.types('q').ends()
    text = '\n'.join(one.screen.all_lines)
    assert 'unseen' not in text
    # the help is no output
    assert 'Ctrl-]' not in text


def test_the_filter_for_all(status, python):
    one = status(python('t', TELLER), size=(40, 24))
    teller = Teller(one)
    one.shows(' 1 ● t')
    one.types('/lo')
    one.shows(' 1 ● t', ' Enter keeps', '/lo')
    line, column = one.screen.cursor
    assert (one.screen.lines[line], column) == ('/lo', 3)
    teller.writes('high\nlow\nLOUD\n')
    search = (' 1 ● t', ' Enter keeps', '/lo')
    one.shows('[t]      low', '[t]      LOUD', *search)
    one.types('w\r').shows('[t]      LOUD', ' 1 ● t', ' /low')
    one.types('LL').shows('[t]      LOUD', ' 1 ● t', ' /low, level WARN')
    teller.writes('[INFO] low 1\n[WARN] low 2\n')
    one.shows('[t]      [WARN] low 2', ' 1 ● t', ' /low, level WARN')
    assert one.screen.colour_of('[WARN]') == 'brown'
    one.types('\x1b').shows('[t]      [WARN] low 2', ' 1 ● t', ' all is shown')
    one.types('M').shows(' 1 ● (t)', ' 1 muted')
    teller.writes('unseen\n')
    teller.has_logged('unseen')
    one.types('Mt').shows(' 1 ● t', ' lines have their time from now on')
    teller.writes('later\n')
    one.screen.shows(
        lambda lines: any(line.endswith(' [t]      later') for line in lines)
    )
    one.types('q').ends()
    text = '\n'.join(one.screen.all_lines)
    assert 'unseen' not in text
    assert 'high' not in text
    log = one.launch.log('t/stdout_stderr.log')
    assert log.startswith(b'high\nlow\nLOUD\n[INFO] low 1\n')


def test_lines_that_change(status, python):
    one = status(python('t', TELLER), size=(40, 12))
    teller = Teller(one)
    one.shows(' 1 ● t')
    teller.writes('low\nlow\nlow\n')
    one.shows('[t]      low', '[t]      low ×3', ' 1 ● t')
    teller.writes('low\n' * 28)
    one.shows('[t]      low', '[t]      low ×31', ' 1 ● t')
    teller.writes('\rload 10%\r')
    teller.writes('load 20%\rload')
    one.shows('[t]      load 20%', '[t]      low ×31', ' 1 ● t')
    teller.writes(' 30%\r\nready\n')
    block = one.shows(
        *('[t]      low', '[t]      low ×31', '[t]      load 30%'),
        *('[t]      ready', ' 1 ● t'),
    )
    assert not any('20%' in line for line in block)
    one.types('q').ends()
    text = '\n'.join(one.screen.all_lines)
    assert text.count('load') == 1
    assert text.count('low') == 2


def test_lines_and_keys_for_a_process(status, python, sleep):
    one = status(
        python('asker', ASKER, emulate_tty=True), sleep('b'), size=(50, 24)
    )
    block = ' 1 ● asker  2 ● b'
    back = ' Ctrl-] goes back'
    one.shows(block)
    one.types('1a').shows('Name:', block, f'{back}  typing at asker', 'asker>')
    one.types('Ada').shows('Name:', block, back, 'asker> Ada')
    one.types('\x01Miss ').shows('Name:', block, back, 'asker> Miss Ada')
    assert one.screen.cursor[1] == len('asker> Miss ')
    one.types('\r').shows(
        *('Name: Miss Ada', 'hello Miss Ada', 'Name:', block, back, 'asker>')
    )
    one.types('\x1b[A\x1d').shows('[launch] asker: detached', block)
    # the keys are ours again
    one.types('2s').shows(' 1 ● asker  2 ■ b')
    block = ' 1 ● asker  2 ■ b'
    one.types('1a').shows(block, back, 'asker> Miss Ada')
    one.types('\r').shows('hello Miss Ada', 'Secret:', block, back, 'asker>')
    one.types('word').shows('Secret:', block, back, 'asker> ****')
    one.types('\r').shows('raw', block, f'{back}  each key goes to asker')
    one.types('x').shows("b'x'", block, back)
    one.types('\x1b[A').shows("b'\\x1b[A'", block, back)
    # nothing runs any more
    one.types('q').ends()
    assert 'word' not in '\n'.join(one.screen.all_lines)


def test_keys_for_what_draws_in_its_terminal(status, python):
    one = status(python('d', DRAWER, emulate_tty=True), size=(50, 20))
    one.shows(' 1 ● d')
    one.types('1a').shows('Name:', ' 1 ● d', ' Ctrl-] goes back', 'd>')
    one.types('Ada\r')
    # it says nothing when it takes keys
    keys = (' 1 ● d', ' Ctrl-] goes back  each key goes to d')
    one.shows('Name: Ada', 'hello Ada', *keys)
    one.types('x').shows("b'x'", *keys)
    # what was answered is not asked again
    one.types('\x1d').shows('[launch] d: detached', ' 1 ● d')
    one.types('1a').shows('[launch] d: attached', *keys)
    one.types('q').ends()
    assert '\n'.join(one.screen.all_lines).count('Name:') == 1


def test_a_pager_has_the_terminal(status, python):
    one = status(
        python('t', TELLER),
        size=(70, 14),
        variables={'PAGER': f"python3 -c '{PAGER}'"},
    )
    teller = Teller(one)
    teller.writes('one\n').shows('[t]      one', ' 1 ● t')
    lines = one.types('1l').shows('paging one')
    assert not any('●' in line for line in lines)
    teller.writes('two\n')
    teller.has_logged('two')
    assert not any('two' in line for line in one.screen.lines)
    one.types('\r').shows('[t]      two', ' 1 ● t')
    # Ctrl-Z ends it, too, and so does the end of the launch
    one.types('1l').shows('paging one')
    one.types('\x1a').shows(' 1 ● t')
    one.types('1l').shows('paging one')
    os.kill(one.launch.popen.pid, 15)
    one.ends()


def test_no_pager_and_a_debugger_that_is_typed_at(status, tmp_path):
    script = tmp_path / 'script.py'
    script.write_text('import time\ntime.sleep(99)\n')
    one = status(
        {'label': 'a', 'argv': [sys.executable, str(script)]},
        variables={'PAGER': '/does/not/exist'},
    )
    one.shows(' 1 ● a')
    one.types('1l').shows(' 1 ● a', ' there is no pager by $PAGER: ')
    one.types('1d')
    one.screen.shows(lambda lines: any('(Pdb)' in line for line in lines))
    one.types('print(6*7)\r')
    one.screen.shows(lambda lines: '42' in lines)
    one.types('\x1dq').ends()


def test_what_was_typed_before_means_nothing(status, sleep):
    one = status(sleep('a'))
    one.types('q1s').shows(' 1 ● a')
    one.types('1').shows(' 1 ● a', ' s stop', ' i info')
    one.types('sq').ends()
