# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Processes under a debugger."""

from collections.abc import Mapping
from dataclasses import replace
import os

from colcon_yamllaunch.language.plan.plan import ParameterFile
from colcon_yamllaunch.language.plan.plan import Process
from colcon_yamllaunch.runtime.core.tasks import RefusedError
from colcon_yamllaunch.runtime.process.spawn import find_program
from colcon_yamllaunch.runtime.process.spawn import interpreter_of
from colcon_yamllaunch.runtime.process.spawn import StartError

_Words = tuple[str | ParameterFile, ...]
_PYTHON = 'python'
_GDB = ('gdb', '-q', '--args')


def debugged(process: Process, environment: Mapping[str, str]) -> Process:
    """
    Return a process under a debugger, with a terminal.

    It waits for commands before the program begins. That of a program in
    Python is `pdb`, which each Python has; of any other it is `gdb`.

    :param environment: The variables of the process
    :raises RefusedError: when `gdb` is needed, and there is none
    """
    path = environment.get('PATH', os.defpath)
    argv = _under_pdb(process, path)
    if argv is None:
        try:
            find_program(_GDB[0], path)
        except StartError as error:
            raise RefusedError(
                f'{process.label} needs gdb to be debugged, which is not '
                'installed: sudo apt install gdb'
            ) from error
        argv = (*_GDB, *process.argv)
    return replace(process, argv=argv, emulate_tty=True)


def _under_pdb(process: Process, path: str) -> _Words | None:
    """Return the command line of a program in Python, None for any other."""
    program, *arguments = process.argv
    try:
        name = str(program)
        if '/' in name:
            name = os.path.join(process.cwd, name)
        found = find_program(name, path)
        if _is_python(found):
            # pdb takes a script or a module, and no options of Python
            first = str(arguments[0]) if arguments else '-'
            if first.startswith('-') and first != '-m':
                return None
            return (program, '-m', 'pdb', *arguments)
        interpreter = interpreter_of(found, path)
    except StartError:
        # which is said when it is started
        return None
    if interpreter is None or not _is_python(interpreter):
        return None
    return (interpreter, '-m', 'pdb', found, *arguments)


def _is_python(program: str) -> bool:
    return os.path.basename(program).startswith(_PYTHON)
