# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Completion as argcomplete's shell code asks for it."""

from pathlib import Path
import re
import subprocess

#: Those of an interactive bash.
BASH_WORDBREAKS = ' \t\n"\'><=;|&(:'
_SEPARATOR = '\v'
_COMMAND = 'exec colcon 8>&1 9>/dev/null 1>&9 </dev/null'


def imported(line: str, cwd: Path, environment: dict[str, str]) -> set[str]:
    """Get the modules that completing a line imports."""
    environment = environment | {'PYTHONPROFILEIMPORTTIME': '1'}
    text = _run(line, cwd, environment, BASH_WORDBREAKS).stderr
    return set(re.findall(r'^import time: .*\| +(\S+)$', text, re.M))


def complete(
    line: str,
    cwd: Path,
    environment: dict[str, str],
    wordbreaks: str = BASH_WORDBREAKS,
) -> list[str]:
    """
    Get what bash would offer behind a line.

    :param line: What has been typed
    :param cwd: Where the user is
    :param environment: The user's environment
    :param wordbreaks: The characters that bash splits words at; what is in
      front of the last of them is left out of the candidates
    """
    done = _run(line, cwd, environment, wordbreaks)
    assert done.returncode == 0
    assert 'Traceback' not in done.stderr
    words = [word for word in done.stdout.split(_SEPARATOR) if word]
    # colcon-mixin offers its options whatever the word begins with
    return [word for word in words if not word.startswith('--mixin')]


def _run(
    line: str, cwd: Path, environment: dict[str, str], wordbreaks: str
) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        ['bash', '-c', _COMMAND],
        cwd=cwd,
        env=environment
        | {
            '_ARGCOMPLETE': '1',
            '_ARGCOMPLETE_SHELL': 'bash',
            '_ARGCOMPLETE_SUPPRESS_SPACE': '1',
            '_ARGCOMPLETE_COMP_WORDBREAKS': wordbreaks,
            '_ARGCOMPLETE_IFS': _SEPARATOR,
            'COMP_LINE': line,
            'COMP_POINT': str(len(line)),
        },
        capture_output=True,
        text=True,
        check=False,
    )
