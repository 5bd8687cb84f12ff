# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The actions that run a process.

What nodes and components share is here too: names, namespaces, parameters.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
import os
import re
import shlex
import shutil
from typing import Any, TypeVar

from colcon_yamllaunch.common.suggestions import way_to_program
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
    known,
    Names,
    Value,
)
from colcon_yamllaunch.language.evaluation.walk import Handler, Walk
from colcon_yamllaunch.language.syntax.diagnostics import error, LaunchError
from colcon_yamllaunch.language.syntax.launch_tree import ParameterValue
from colcon_yamllaunch.language.syntax.text import Substitution, Text
from colcon_yamllaunch.language.vocabulary.parameter import (
    coerce,
    infer,
    Parameter,
    parameter_file,
    ParameterContent,
    ParameterTypeError,
    parse_boolean,
)
from colcon_yamllaunch.plan.plan import (
    OUTPUT_MODES,
    ParameterFile,
    Process,
    SetParameter,
)
from colcon_yamllaunch.plan.position import Position

#: The environment variable that replaces every `output`, as in ROS 2.
OUTPUT_OVERRIDE = 'OVERRIDE_LAUNCH_PROCESS_OUTPUT'

Parsed = TypeVar('Parsed')
_FIRST_WORD = re.compile("""("[^"]*"|'[^']*'|[^\\s"'])*""")

# a text that is not known is None
Arguments = list[str | ParameterFile | None]

#: What is said of a parameter that is an empty list.
EMPTY_LIST = 'nodes do not accept an empty list, which has no type'

_LIST = 'list_of_'

#: A value, None when it is not known, and where what it is made of was set.
Content = tuple[ParameterContent | None, tuple[Position, ...]]

_NODE_NAME = re.compile(r'[A-Za-z_][A-Za-z0-9_]*')
_NAMESPACE = re.compile(r'/|(/[A-Za-z_~{}][A-Za-z0-9_~{}]*)+')


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


def node_name(attributes: Attributes) -> Value | None:
    """Return the name of a node, None when it is left out."""
    name = attributes.value('name')
    if name is None or name.text is None:
        return name
    problem = node_name_problem(name.text)
    if problem is not None:
        attributes.fail('name', problem)
        return name.forgotten()
    return name


def node_namespace(walk: Walk, attributes: Attributes) -> Value | None:
    """Return the namespace of a node, None when it has none."""
    if 'namespace' not in attributes:
        return walk.scope.namespace
    inner = attributes.required('namespace')
    return inner_namespace(walk, attributes, inner)


def full_node_name(
    name: Value | None, namespace: Value | None
) -> Value | None:
    """Return the full name of a node, None when it names itself."""
    if name is None or namespace is None or name.text is None:
        text = None if name is None else name.text
        return name and name._replace(text=text and f'/{text}')
    outer = namespace.text
    text = None if outer is None else f'{outer.rstrip("/")}/{name.text}'
    sources = name.sources | namespace.sources
    return name._replace(text=text, sources=sources)


def remap_rules(walk: Walk, attributes: Attributes) -> list[str]:
    """Return the remapping rules of a node; the first that matches counts."""
    of_scope = walk.scope.remaps
    pairs = [*of_scope]
    seen: set[str] = set()
    for remap in attributes.items('remap'):
        old, new = remap.text('from'), remap.text('to')
        if old is None:
            continue
        # the first rule that matches counts (rcl_remap)
        is_done = old in seen or old in {name for name, _ in of_scope}
        if is_done and not walk.is_launch:
            by = 'before' if old in seen else "by 'set_remap'"
            text = remap.item.texts['from']
            walk.warn(
                f"'{old}' is remapped {by} already, so this has no effect",
                text,
                'remove one of the two',
            )
        seen.add(old)
        pairs.append((old, new or ''))
    return [f'{old}:={new}' for old, new in pairs]


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


def node_name_problem(name: str) -> str | None:
    """Return why no node can have a name, or None if one can."""
    if _NODE_NAME.fullmatch(name):
        return None
    return (
        f"the node name '{name}' may only have letters, digits and "
        'underscores, and cannot be empty or start with a digit'
    )


def namespace_problem(namespace: str) -> str | None:
    """Return why a text is no absolute namespace, or None if it is one."""
    if _NAMESPACE.fullmatch(namespace):
        return None
    return (
        f"the namespace '{namespace}' may only have letters, digits, "
        'underscores and slashes, and none of its parts can be empty or start '
        'with a digit'
    )


def join_namespace(base: str | None, namespace: str) -> str:
    """
    Return the namespace that results from one within another.

    :param base: The outer namespace, absolute, if there is one
    :param namespace: The inner one; an absolute one replaces the outer one
    """
    if not namespace.startswith('/'):
        namespace = f'{(base or "").rstrip("/")}/{namespace}'
    return namespace.rstrip('/') or '/'


def inner_namespace(
    walk: Walk, attributes: Attributes, inner: Value
) -> Value | None:
    """
    Return a namespace within that of the scope.

    :param attributes: Those with the inner one as `namespace`
    """
    outer = walk.scope.namespace
    if inner.text is None:
        return inner
    base = None if outer is None else outer.text
    namespace = join_namespace(base, inner.text)
    problem = namespace_problem(namespace)
    if problem is not None:
        attributes.fail('namespace', problem)
        return inner.forgotten()
    if outer is not None and base is None and inner.text[:1] != '/':
        return outer
    return known(namespace)


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


def parameter_arguments(
    walk: Walk,
    attributes: Attributes,
    node: str,
    pattern: str,
    full_name: Value | None,
) -> list[str | ParameterFile]:
    """
    Return the arguments for a node's own parameters, in order.

    :param attributes: Those of the node
    :param node: What to call it in messages
    :param pattern: The nodes that a file of parameters is for
    :param full_name: The full name of the node, None when it names itself
    """
    arguments: list[str | ParameterFile] = []
    pending: list[SetParameter] = []

    def flush() -> None:
        if pending:
            file = parameter_file(pattern, pending)
            arguments.extend(['--params-file', file])
            pending.clear()

    if walk.scope.parameters:
        from colcon_yamllaunch.language.actions import parameter_files

        parameter_files.note_sections_of_scope(walk, full_name)
    for entry in attributes.items('param'):
        if 'from' in entry.item.texts:
            flush()
            # many launches have no parameter files
            from colcon_yamllaunch.language.actions import parameter_files

            file = parameter_files.file_of(walk, entry)
            if file is not None:
                arguments.extend(['--params-file', file])
            if isinstance(file, str):
                parameter_files.note_sections(
                    walk,
                    os.path.join(walk.cwd, file),
                    walk.place_of(entry.item.texts['from']),
                    full_name,
                    is_own=True,
                )
            continue
        for parameter in nested_parameters(walk, entry, node):
            if parameter.value is not None:
                pending.append(parameter.as_set())
    flush()
    return arguments


def parameter_value(
    walk: Walk,
    value: ParameterValue,
    kind: str | None,
    *,
    infer_text: bool = False,
    what: str = '',
) -> Content:
    """
    Return the value of a parameter, and its origins.

    :param kind: The type that the launch file gives, or None
    :param infer_text: Whether a text without substitutions is taken for what
      YAML takes it for, as ROS 2's `set_parameter` does
    :param what: What a message starts with
    """
    try:
        if not value.is_list:
            return _scalar(walk, value.texts[0], kind, infer_text)
        return _list(walk, value, kind)
    except LaunchError as e:
        walk.fail(e.of(what))
        return None, ()


def _list(walk: Walk, value: ParameterValue, kind: str | None) -> Content:
    if kind is not None and not kind.startswith(_LIST) and kind != 'yaml':
        raise error(f'the value is a list, not of type {kind}', value.position)
    element = None
    if kind is not None and kind.startswith(_LIST):
        element = kind[len(_LIST) :]
    contents = [_scalar(walk, text, element, False) for text in value.texts]
    for text, (content, _) in zip(value.texts, contents, strict=True):
        if isinstance(content, tuple):
            raise error('a list cannot have a list in it', text)
    values = [v for v, _ in contents if not isinstance(v, tuple | None)]
    kinds = {type(v) for v in values}
    if len(kinds) > 1:
        raise error(
            'the values of a list have one type, here they have '
            + ' and '.join(sorted(k.__name__ for k in kinds)),
            value.position,
            hint='write 1.0 for a whole number among others'
            if kinds == {int, float}
            else 'quote the values that are texts',
        )
    if not contents:
        walk.warn(EMPTY_LIST, value.position)
        return (), ()
    is_known = len(values) == len(contents)
    return tuple(values) if is_known else None, contents[-1][1]


def _scalar(
    walk: Walk, text: Text, kind: str | None, infer_text: bool
) -> Content:
    if kind is not None and kind.startswith(_LIST):
        raise error(
            f'the value is no list, but its type is {kind}',
            text,
            hint='write it as [first, second, …]',
        )
    literal = text.literal
    is_typed = kind not in (None, 'yaml')
    if literal is None or (is_typed and text.is_coerced):
        return _evaluated(walk, text, kind)
    if infer_text and text.kind == 'str':
        return _evaluated(walk, text, None)
    value = literal if text.kind == 'str' else text.value
    assert value is not None
    found = type(value).__name__
    if is_typed and found != kind:
        hint = 'change the value or the type'
        if kind == 'str':
            hint = f"quote it: '{text.plain}'"
        elif kind == 'float' and found == 'int':
            hint = f'write {text.plain}.0'
        raise error(
            f'the value is of type {found}, not {kind}', text, hint=hint
        )
    return value, ()


def _evaluated(walk: Walk, text: Text, kind: str | None) -> Content:
    value = walk.value(text)
    if value.text is None:
        return None, ()
    try:
        if kind is None:
            return infer(value.text), value.origins
        return coerce(value.text, kind), value.origins
    except ParameterTypeError as e:
        raise error(str(e), text, origins=value.origins) from e


def nested_parameters(
    walk: Walk, entry: Attributes, node: str, prefix: str = ''
) -> Iterator[Parameter]:
    """
    Iterate over the parameters that an item of `param` sets.

    :param node: What to call their node in messages
    :param prefix: What the names of those around it start with
    """
    name = prefix + (entry.text('name') or '')
    if 'param' in entry.item.items:
        for inner in entry.items('param'):
            if 'from' in inner:
                inner.fail_as_whole(
                    "'from' cannot stand within a parameter",
                    "make it an item of the node's 'param'",
                )
            else:
                yield from nested_parameters(walk, inner, node, f'{name}.')
        return
    kind = entry.plain('type') if 'type' in entry.item.texts else None
    what = f"parameter '{name}' of node '{node}': "
    written = entry.item.values['value']
    value, origins = parameter_value(walk, written, kind, what=what)
    yield Parameter(name, value, written.position, origins)


#: What does each action that runs a process.
PROCESS_HANDLERS: Mapping[str, Handler] = {
    'executable': _executable,
    'node': run_node,
    'lifecycle_node': run_node,
}
