# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The actions that run a process."""

from collections.abc import Iterator
import os
import re
import shlex
import shutil

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.suggestions import did_you_mean
from colcon_yamllaunch.language.evaluation.evaluation_state import (
    ExecutableUse,
)
from colcon_yamllaunch.language.evaluation.evaluation_state import State
from colcon_yamllaunch.language.evaluation.node_parameters import (
    parameter_arguments,
)
from colcon_yamllaunch.language.evaluation.scope_actions import check_variable
from colcon_yamllaunch.language.plan.plan import DEFAULT_SIGKILL_TIMEOUT
from colcon_yamllaunch.language.plan.plan import DEFAULT_SIGTERM_TIMEOUT
from colcon_yamllaunch.language.plan.plan import OUTPUT_MODES
from colcon_yamllaunch.language.plan.plan import ParameterFile
from colcon_yamllaunch.language.plan.plan import Process
from colcon_yamllaunch.language.plan.plan import SetParameter
from colcon_yamllaunch.language.plan.plan import UNLIMITED_RETRIES
from colcon_yamllaunch.language.syntax.command_line import split_command_line
from colcon_yamllaunch.language.syntax.command_line import UnclosedQuoteError
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.language.syntax.ros_names import join_namespace
from colcon_yamllaunch.language.syntax.ros_names import namespace_problem
from colcon_yamllaunch.language.syntax.ros_names import node_name_problem
from colcon_yamllaunch.language.tree.launch_tree import Item
from colcon_yamllaunch.language.vocabulary.scope import environment_changes
from colcon_yamllaunch.language.vocabulary.substitutions import parse_boolean

#: The environment variable that replaces every `output`, as in ROS 2.
OUTPUT_OVERRIDE = 'OVERRIDE_LAUNCH_PROCESS_OUTPUT'
#: The launch arguments that every process heeds, as in ROS 2.
PROCESS_ARGUMENTS = (
    'launch-prefix',
    'launch-prefix-filter',
    'emulate_tty',
    'sigterm_timeout',
    'sigkill_timeout',
)

Arguments = list[str | ParameterFile]


@dataclass(frozen=True, slots=True)
class _Program:
    """What distinguishes one process from another but its attributes."""

    name: str
    argv: Arguments
    package: str | None = None
    node_name: str | None = None
    parameters: tuple[SetParameter, ...] = ()


def visit_executable(state: State, item: Item) -> None:
    """Run a program."""
    argv = _command(state, item, 'cmd')
    if not argv:
        raise error("'cmd' is empty", item.position)
    name = state.text(item, 'name') or os.path.basename(str(argv[0]))
    _add_process(state, item, _Program(name, argv))


def visit_node(state: State, item: Item) -> None:
    """Run a ROS node."""
    package = state.optional_text(item, 'pkg')
    program = state.text(item, 'exec')
    argv: Arguments = [program]
    if package is not None:
        argv = [_executable(state, item, package, program)]
    name = _node_name(state, item)
    namespace = _namespace(state, item)
    is_known = name is not None and namespace is not None
    full_name = f'{(namespace or "").rstrip("/")}/{name}' if name else None
    argv += _command(state, item, 'args')
    if 'ros_args' in item.texts or 'ros_args' in item.lists:
        argv += ['--ros-args', *_command(state, item, 'ros_args')]
    argv.append('--ros-args')
    if name is not None:
        argv += ['-r', f'__node:={name}']
    if namespace is not None:
        argv += ['-r', f'__ns:={namespace}']
    own = parameter_arguments(
        state,
        item,
        node=name or program,
        pattern=str(full_name) if is_known else '/**',
    )
    argv += [*_scope_parameters(state), *own, *_remaps(state, item)]
    parameters = tuple(_parameters(state, own))
    label = state.text(item, 'exec_name') or os.path.basename(program)
    node = _Program(label, argv, package, full_name, parameters)
    _add_process(state, item, node)
    _check_unique(state, item, full_name)


def _executable(state: State, item: Item, package: str, name: str) -> str:
    text = item.texts['pkg']
    if state.packages.prefix(package) is None:
        raise error(
            f"there is no package '{package}' in the workspace or an underlay",
            text.position,
            hint=did_you_mean(package, state.packages.names()),
            length=text.length,
        )
    state.use_package(package, text.position)
    text = item.texts['exec']
    path = state.packages.executable(package, name)
    if path is None:
        raise error(
            f"package '{package}' has no executable '{name}'",
            text.position,
            hint=state.packages.explain_executable(package, name),
            length=text.length,
        )
    state.executables.append(ExecutableUse(package, name, path, text.position))
    return path


def _node_name(state: State, item: Item) -> str | None:
    name = state.optional_text(item, 'name')
    if name is None:
        return None
    problem = node_name_problem(name)
    if problem is not None:
        text = item.texts['name']
        raise error(problem, text.position, length=text.length)
    return name


def _namespace(state: State, item: Item) -> str | None:
    own = state.optional_text(item, 'namespace')
    if own is None:
        return state.scope.namespace
    namespace = join_namespace(state.scope.namespace, own)
    problem = namespace_problem(namespace)
    if problem is not None:
        text = item.texts['namespace']
        raise error(problem, text.position, length=text.length)
    return namespace


def _check_unique(state: State, item: Item, full_name: str | None) -> None:
    if full_name is None:
        return
    if full_name in state.node_names:
        text = item.texts['name']
        state.warn(
            f"another node of this launch has the name '{full_name}' too",
            text.position,
            length=text.length,
        )
    state.node_names.add(full_name)


def _scope_parameters(state: State) -> Arguments:
    arguments: Arguments = []
    for parameter in state.scope.parameters:
        if isinstance(parameter, str):
            arguments += ['--params-file', parameter]
        else:
            given = parameter.as_set()
            arguments += ['-p', f'{given.name}:={given.value}']
    return arguments


def _parameters(state: State, own: Arguments) -> Iterator[SetParameter]:
    for parameter in state.scope.parameters:
        if not isinstance(parameter, str):
            yield parameter.as_set()
    for argument in own:
        if isinstance(argument, ParameterFile):
            yield from argument.parameters


def _remaps(state: State, item: Item) -> Arguments:
    pairs = list(state.scope.remaps)
    for remap in item.items.get('remap', ()):
        pairs.append((state.text(remap, 'from'), state.text(remap, 'to')))
    return [a for old, new in pairs for a in ('-r', f'{old}:={new}')]


def _command(state: State, item: Item, name: str) -> Arguments:
    """Return an attribute's command line as arguments."""
    if name in item.lists:
        return [text.evaluate(state) for text in item.lists[name]]
    text = item.texts.get(name)
    if text is None:
        return []
    try:
        pieces = split_command_line(text.template)
    except UnclosedQuoteError as e:
        raise error(
            f"'{name}' has a {e} that is not closed",
            text.position,
            hint='close it, or put it into quotes of the other kind',
            length=text.length,
        ) from e
    return [text.evaluate_part(piece, state) for piece in pieces]


def _add_process(state: State, item: Item, program: _Program) -> None:
    environment = dict(state.scope.environment)
    for pair in item.items.get('env', ()):
        name, value = state.text(pair, 'name'), state.text(pair, 'value')
        check_variable(pair, name, value)
        environment[name] = value
    cwd = os.path.join(state.cwd, state.text(item, 'cwd'))
    argv: Arguments = [*_prefix(state, item, program), *program.argv]
    if state.boolean(item, 'shell', False):
        argv = _through_shell(argv)
    else:
        _check_program(state, item, str(argv[0]), cwd, environment)
    state.entries.append(
        Process(
            label=state.label(program.name),
            argv=tuple(argv),
            cwd=os.path.normpath(cwd),
            position=item.position,
            environment=environment_changes(state.environment, environment),
            output=_output(state, item),
            emulate_tty=_emulate_tty(state, item),
            respawn=state.boolean(item, 'respawn', False),
            respawn_delay=state.seconds(item, 'respawn_delay') or 0.0,
            respawn_max_retries=state.integer(
                item, 'respawn_max_retries', UNLIMITED_RETRIES
            ),
            sigterm_timeout=_timeout(
                state, item, 'sigterm_timeout', DEFAULT_SIGTERM_TIMEOUT
            ),
            sigkill_timeout=_timeout(
                state, item, 'sigkill_timeout', DEFAULT_SIGKILL_TIMEOUT
            ),
            on_exit_shutdown='on_exit' in item.texts,
            package=program.package,
            node_name=program.node_name,
            parameters=program.parameters,
            block=state.block,
        )
    )


def _prefix(state: State, item: Item, program: _Program) -> list[str]:
    text = item.texts.get('launch-prefix')
    if text is not None:
        prefix = text.evaluate(state)
    else:
        configurations = state.scope.configurations
        prefix = configurations.get('launch-prefix', '')
        pattern = configurations.get('launch-prefix-filter')
        name = os.path.basename(str(program.argv[0]))
        if pattern is not None and not _matches(pattern, name):
            prefix = ''
    try:
        return shlex.split(prefix)
    except ValueError as e:
        raise error(
            f"the launch prefix '{prefix}' has an open quote",
            text.position if text else item.position,
        ) from e


def _matches(pattern: str, name: str) -> bool:
    try:
        return re.match(pattern, name) is not None
    except re.error as e:
        raise error(
            f"'launch-prefix-filter:={pattern}' is no regular expression: {e}"
        ) from e


def _through_shell(argv: Arguments) -> Arguments:
    # ROS 2 joins the arguments without quoting them; the paths of parameter
    # files, which are not known yet, come in as the shell's own arguments
    files: Arguments = []
    words = []
    for argument in argv:
        if isinstance(argument, ParameterFile):
            files.append(argument)
            words.append(f'"${{{len(files)}}}"')
        else:
            words.append(argument)
    shell: Arguments = ['/bin/sh', '-c', ' '.join(words)]
    return [*shell, 'sh', *files] if files else shell


def _check_program(
    state: State,
    item: Item,
    program: str,
    cwd: str,
    environment: dict[str, str],
) -> None:
    if '/' in program:
        full = os.path.join(cwd, program)
        found = _is_program(full) or state.packages.may_appear(full)
    else:
        path = environment.get('PATH', os.defpath)
        found = shutil.which(program, path=path) is not None
    if found or any(use.path == program for use in state.executables):
        return
    text = (
        item.texts.get('cmd') or item.texts.get('exec')
        if 'launch-prefix' not in item.texts
        else item.texts['launch-prefix']
    )
    where = '' if '/' in program else ' on the PATH'
    raise error(
        f"there is no executable '{program}'{where}",
        text.position if text else item.position,
        hint=None
        if '/' in program
        else "name its package with 'pkg'"
        if 'exec' in item.texts
        else 'install it, or correct the name',
        length=text.length if text else 1,
        may_pass_after_build=True,
    )


def _is_program(path: str) -> bool:
    return os.path.isfile(path) and os.access(path, os.X_OK)


def _output(state: State, item: Item) -> str:
    override = state.environment.get(OUTPUT_OVERRIDE)
    if override:
        if override not in OUTPUT_MODES:
            raise error(
                f"the environment variable {OUTPUT_OVERRIDE} is '{override}'",
                hint=f'it is one of {", ".join(OUTPUT_MODES)}',
            )
        return override
    output = state.text(item, 'output', OUTPUT_MODES[0])
    if output not in OUTPUT_MODES:
        text = item.texts['output']
        raise error(
            f"'output' cannot be '{output}'",
            text.position,
            hint=did_you_mean(output, OUTPUT_MODES)
            or f'it is one of {", ".join(OUTPUT_MODES)}',
            length=text.length,
        )
    return output


def _emulate_tty(state: State, item: Item) -> bool:
    # the launch argument is stronger than every process, as in ROS 2
    override = state.scope.configurations.get('emulate_tty')
    if override is None:
        return state.boolean(item, 'emulate_tty', False)
    value = parse_boolean(override)
    if value is None:
        raise error(
            f"launch argument 'emulate_tty' is '{override}'",
            hint='it is true or false',
        )
    return value


def _timeout(state: State, item: Item, name: str, default: float) -> float:
    own = state.seconds(item, name)
    if own is not None:
        return own
    return general_timeout(state, name, default)


def general_timeout(state: State, name: str, default: float) -> float:
    """
    Return the timeout for processes that set none of their own.

    :param name: The launch configuration, as in ROS 2
    :raises LaunchError: if it is no number of seconds
    """
    general = state.scope.configurations.get(name)
    if general is None:
        return default
    try:
        value = float(general)
    except ValueError:
        value = -1.0
    if not 0 <= value < float('inf'):
        raise error(
            f"launch argument '{name}' is '{general}'",
            hint='it is a number of seconds',
        )
    return value
