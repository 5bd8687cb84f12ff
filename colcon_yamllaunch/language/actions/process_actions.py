# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The actions that run a process."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
import os
import re
import shlex
import shutil
from typing import Any, TypeVar

from colcon_yamllaunch.common.suggestions import way_to_program
from colcon_yamllaunch.language.actions.node_names import (
    full_node_name,
    node_name,
    node_namespace,
    remap_rules,
)
from colcon_yamllaunch.language.actions.parameters import parameter_arguments
from colcon_yamllaunch.language.evaluation.attributes import (
    Attributes,
    parse_seconds,
    Word,
)
from colcon_yamllaunch.language.evaluation.findings import (
    ExecutableUse,
    ProgramUse,
)
from colcon_yamllaunch.language.evaluation.scope import (
    environment_changes,
    Names,
    Value,
)
from colcon_yamllaunch.language.evaluation.walk import Handler, Walk
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.language.syntax.text import Substitution, Text
from colcon_yamllaunch.language.vocabulary.parameter import parse_boolean
from colcon_yamllaunch.plan.plan import (
    OUTPUT_MODES,
    ParameterFile,
    Process,
    SetParameter,
)

#: The environment variable that replaces every `output`, as in ROS 2.
OUTPUT_OVERRIDE = 'OVERRIDE_LAUNCH_PROCESS_OUTPUT'

Parsed = TypeVar('Parsed')
_FIRST_WORD = re.compile("""("[^"]*"|'[^']*'|[^\\s"'])*""")

# a text that is not known is None
Arguments = list[str | ParameterFile | None]


def _executable(walk: Walk, attributes: Attributes) -> None:
    words = attributes.command('cmd')
    if not words:
        attributes.fail_as_whole("'cmd' is empty")
        return
    argv = _texts(words)
    name = attributes.text('name') or os.path.basename(argv[0] or '')
    _add_process(walk, attributes, name, [*argv], words[0].text)


def run_node(walk: Walk, attributes: Attributes) -> str | None:
    """Run the program of a node; return its full name as far as known."""
    is_container = attributes.name == 'node_container'
    is_lifecycle = attributes.name == 'lifecycle_node'
    package = attributes.value('pkg')
    program = attributes.text('exec')
    path = program
    if package is not None:
        path = _package_program(walk, attributes, package.text, program)
    name = node_name(attributes)
    namespace = node_namespace(walk, attributes)
    full_name = full_node_name(name, namespace)
    full_text = None if full_name is None else full_name.text
    argv: Arguments = [path, *_texts(attributes.command('args'))]
    if 'ros_args' in attributes:
        argv += ['--ros-args', *_texts(attributes.command('ros_args'))]
    argv.append('--ros-args')
    if name is not None:
        argv += ['-r', f'__node:={name.text}']
    if namespace is not None:
        argv += ['-r', f'__ns:={namespace.text}']
    own = parameter_arguments(
        walk,
        attributes,
        (name and name.text) or program or '',
        full_text if full_text and namespace is not None else '/**',
        full_name,
    )
    parameters: list[SetParameter] = []
    for parameter in walk.scope.parameters:
        if isinstance(parameter, str):
            argv += ['--params-file', parameter]
        elif parameter.value is not None:
            given = parameter.as_set()
            parameters.append(given)
            argv += ['-p', f'{given.name}:={given.value}']
    for argument in own:
        if isinstance(argument, ParameterFile):
            parameters += argument.parameters
    argv += own
    for rule in remap_rules(walk, attributes):
        argv += ['-r', rule]
    _add_process(
        walk,
        attributes,
        attributes.text('exec_name') or os.path.basename(program or ''),
        argv,
        attributes.item.texts['exec'],
        "name its package with 'pkg'",
        package=None if package is None else package.text,
        node_name=full_text,
        parameters=tuple(parameters),
        is_container=is_container,
        is_lifecycle=is_lifecycle,
        autostart=is_lifecycle and attributes.boolean('autostart') is True,
    )
    if full_text is not None:
        walk.note_node(full_text, attributes.item.texts['name'])
    elif name is not None or is_container:
        walk.may_have_others = True
    return full_text


def _texts(words: list[Word]) -> list[str | None]:
    return [word.value.text for word in words]


def _package_program(
    walk: Walk, attributes: Attributes, package: str | None, name: str | None
) -> str | None:
    if package is None:
        return None
    packages = walk.packages
    if packages.prefix(package) is None:
        attributes.fail('pkg', *walk.no_package(package))
        return None
    walk.use_package(package, attributes.item.texts['pkg'].position)
    if name is None:
        return None
    path = packages.executable(package, name)
    if path is None:
        attributes.fail(
            'exec',
            f"package '{package}' has no executable '{name}'",
            packages.explain_executable(package, name),
        )
        return None
    position = attributes.item.texts['exec'].position
    walk.executables.append(ExecutableUse(package, name, path, position))
    return path


def _add_process(
    walk: Walk,
    attributes: Attributes,
    program: str,
    command: Arguments,
    text: Text,
    hint: str | None = None,
    **fields: Any,
) -> None:
    """
    Add a process to the plan.

    :param program: What ROS 2 calls it, without its number
    :param command: Its command line but for the launch prefix
    :param text: What names the program
    :param hint: The fix if there is no such program
    :param fields: Fields of the process that are not among the attributes
    """
    variables = walk.scope.environment.inner()
    for pair in attributes.items('env'):
        value = pair.required('value')
        set_variable(variables, pair, pair.text('name'), value)
    cwd = os.path.join(walk.cwd, attributes.text('cwd') or '')
    prefix = _prefix(walk, attributes, os.path.basename(str(command[0])))
    if prefix is None:
        return
    place = walk.place_of(text)
    if 'launch-prefix' in attributes:
        place = walk.place_of(attributes.item.texts['launch-prefix'])
        hint = None
    elif text is attributes.item.texts.get('cmd'):
        position, length = text.position_at(0), _program_length(text)
        place = replace(place, position=position, length=length)
    # in a launch, all arguments are known
    argv = [a for a in (*prefix, *command) if a is not None]
    uses_shell = attributes.boolean('shell')
    if uses_shell:
        argv = through_shell(argv)
    elif uses_shell is False and (
        walk.is_launch or not prefix or 'launch-prefix' in attributes
    ):
        first = prefix[0] if prefix else command[0]
        own = variables.own.get('PATH')
        if own is None:
            path = walk.search_path()
        else:
            path = own.text if walk.has_environment else None
        if first is not None:
            use = ProgramUse(place, hint)
            _check_program(walk, str(first), cwd, path, use)
    if not walk.is_launch:
        return
    name = walk.draft.process_name(program)
    walk.programs[name] = ProgramUse(place, hint)
    # the launch argument is stronger than every process, as in ROS 2
    is_tty = _general(walk, 'emulate_tty', parse_boolean, 'true or false')
    if is_tty is None:
        is_tty = attributes.boolean('emulate_tty') is True
    walk.draft.entries.append(
        Process(
            label=name,
            argv=tuple(argv),
            cwd=os.path.normpath(cwd),
            position=attributes.position,
            name=name,
            environment=environment_changes(walk.environment, variables),
            output=_output(walk, attributes),
            emulate_tty=is_tty,
            respawn=attributes.boolean('respawn') is True,
            respawn_delay=attributes.seconds('respawn_delay') or 0.0,
            respawn_max_retries=attributes.whole('respawn_max_retries') or 0,
            sigterm_timeout=_timeout(walk, attributes, 'sigterm_timeout'),
            sigkill_timeout=_timeout(walk, attributes, 'sigkill_timeout'),
            on_exit_shutdown='on_exit' in attributes,
            block=walk.draft.block,
            **fields,
        )
    )


def _prefix(
    walk: Walk, attributes: Attributes, program: str
) -> list[str] | None:
    """Return the words in front of a command line, None when not known."""
    value = attributes.value('launch-prefix')
    fail = attributes.fail_as_whole
    if value is None:
        value = walk.scope.configurations.get('launch-prefix')
        if value is None:
            return []
        pattern = _configured(walk, 'launch-prefix-filter')
        try:
            if pattern is not None and not re.match(pattern, program):
                return []
        except re.error as e:
            walk.fail(
                error(
                    f"'launch-prefix-filter:={pattern}' is no regular "
                    f'expression: {e}'
                )
            )
            return []
    else:
        fail = partial(attributes.fail, 'launch-prefix')
    if value.text is None:
        return None
    try:
        return shlex.split(value.text)
    except ValueError:
        fail(f"the launch prefix '{value.text}' has an open quote")
        return None


def through_shell(
    argv: list[str | ParameterFile],
) -> list[str | ParameterFile]:
    """Return the command that has a shell run the words."""
    # ROS 2 joins the arguments without quoting them; the paths of parameter
    # files, which are not known yet, come in as the shell's own arguments
    files: list[str | ParameterFile] = []
    words = []
    for argument in argv:
        if isinstance(argument, ParameterFile):
            files.append(argument)
            words.append(f'"${{{len(files)}}}"')
        else:
            words.append(argument)
    shell: list[str | ParameterFile] = ['/bin/sh', '-c', ' '.join(words)]
    return [*shell, 'sh', *files] if files else shell


def _check_program(
    walk: Walk, name: str, cwd: str, path: str | None, use: ProgramUse
) -> None:
    """
    Check that there is a program.

    :param path: The `PATH` to search, None when it is not known
    """
    full_path = os.path.join(cwd, name)
    # a launch goes on without a program that this machine lacks
    if not (walk.checks_programs or _is_in_package(walk, full_path)):
        return
    if '/' in name:
        found = walk.is_program(full_path)
    else:
        found = path is None or shutil.which(name, path=path) is not None
    if found or any(one.path == name for one in walk.executables):
        return
    walk.fail(
        error(
            walk.no_program(name),
            use.place,
            hint=use.hint or way_to_program(name, cwd),
            may_pass_after_build=True,
        )
    )


def _is_in_package(walk: Walk, path: str) -> bool:
    prefixes = ((n, walk.packages.prefix(n)) for n in walk.packages_used)
    return any(
        prefix is not None
        and path.startswith(f'{prefix}/')
        and f'/{name}/' in path
        for name, prefix in prefixes
    )


def _program_length(command: Text) -> int:
    """Return how many characters of a command line are its program."""
    end = 0
    for part in command.template.parts:
        if isinstance(part, Substitution):
            end = part.end
            continue
        found = _FIRST_WORD.match(part)
        end += found.end() if found else 0
        if found and found.end() < len(part):
            break
    return end


def _output(walk: Walk, attributes: Attributes) -> str:
    override = walk.environment.get(OUTPUT_OVERRIDE)
    if not override:
        return attributes.text('output') or ''
    if override not in OUTPUT_MODES:
        raise error(
            f"the environment variable {OUTPUT_OVERRIDE} is '{override}'",
            hint=f'it is one of {", ".join(OUTPUT_MODES)}',
        )
    return override


def _timeout(walk: Walk, attributes: Attributes, name: str) -> float:
    own = attributes.seconds(name) or 0.0
    return own if name in attributes else general_timeout(walk, name, own)


def general_timeout(walk: Walk, name: str, default: float) -> float:
    """
    Return the timeout for processes that set none of their own.

    :param name: The launch configuration, as in ROS 2
    :raises LaunchError: when it is no number of seconds
    """
    general = _general(walk, name, parse_seconds, 'a number of seconds')
    return default if general is None else general


def _general(
    walk: Walk, name: str, parse: Callable[[str], Parsed | None], what: str
) -> Parsed | None:
    """Return the value that a launch configuration has for all processes."""
    text = _configured(walk, name)
    value = None if text is None else parse(text)
    if text is not None and value is None:
        message = f"launch argument '{name}' is '{text}'"
        raise error(message, hint=f'it is {what}')
    return value


def _configured(walk: Walk, name: str) -> str | None:
    value = walk.scope.configurations.get(name)
    return None if value is None else value.text


def set_variable(
    variables: Names, attributes: Attributes, name: str | None, value: Value
) -> None:
    """Set an environment variable if a process can have it (POSIX)."""
    if name is not None and (
        not name or '=' in name or '\0' in name + (value.text or '')
    ):
        attributes.fail_as_whole(
            f"there can be no environment variable '{name}' with that value"
        )
    variables.set(name, value)


#: What does each action that runs a process.
PROCESS_HANDLERS: Mapping[str, Handler] = {
    'executable': _executable,
    'node': run_node,
    'lifecycle_node': run_node,
}
