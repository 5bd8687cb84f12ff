# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The table of actions and their attributes.

Everything that depends on which actions there are comes from here: reading a
launch file, the types of its values, suggestions for a misspelled name, the
JSON Schema and the reference page. To add an action is to add an entry here,
what does it to a module of `actions/`, and an example: CONTRIBUTING.md shows
it.

The ROS 2 releases are those whose launch files in YAML or XML have the action
or attribute (the change logs and branches of ros2/launch and ros2/launch_ros);
what is older than Humble counts as Humble.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from enum import Enum

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.suggestions import one_of
from colcon_yamllaunch.plan.plan import (
    DEFAULT_SIGKILL_TIMEOUT,
    DEFAULT_SIGTERM_TIMEOUT,
    OUTPUT_MODES,
    UNLIMITED_RETRIES,
)

#: The ROS 2 releases that are told apart, in the order they came; Rolling has
#: what no release has yet.
RELEASES = ('Humble', 'Iron', 'Jazzy', 'Kilted', 'Lyrical', 'Rolling')


class Type(Enum):
    """What the value of an attribute is."""

    #: text with substitutions
    TEXT = 'text'
    #: text with substitutions that names something; a YAML boolean is an
    #: error, since it is a name that was not quoted
    NAME = 'name'
    #: text without substitutions
    PLAIN = 'plain text'
    #: true, 1, false or 0, or text that is one after its substitutions
    CONDITION = 'condition'
    #: a boolean, or text that is one after its substitutions
    BOOLEAN = 'boolean'
    #: a whole number, or text that is one after its substitutions
    INTEGER = 'integer'
    #: a number >= 0, or text that is one after its substitutions
    SECONDS = 'seconds'
    #: a command line, or a list with one argument an item
    COMMAND = 'command line'
    #: the value of a parameter: any scalar, or a list of one kind of scalar
    VALUE = 'parameter value'
    #: a list of mappings
    ITEMS = 'list'
    #: a list of actions
    ACTIONS = 'actions'


@dataclass(frozen=True, slots=True)
class Attribute:
    """
    An attribute of an action.

    :param name: The key in the launch file
    :param type: What its value is
    :param help: What it is for, in one sentence
    :param required: Whether the action needs it
    :param items: The attributes of each item of a list
    :param values: The values that it may have; empty when any
    :param default: What it is when left out, as it would be written; None
      when it then has no value
    :param since: The first ROS 2 release that has it; None when it is as old
      as its action
    :param pattern: What its whole text looks like, unless there are
      substitutions in it; a regular expression of the part that Python and
      ECMA 262 (JSON Schema) have in common
    :param ignore_case: Whether its values may be written in any case
    """

    name: str
    type: Type
    help: str
    required: bool = False
    items: 'tuple[Attribute, ...]' = ()
    values: tuple[str, ...] = ()
    default: str | None = None
    since: str | None = None
    pattern: str | None = None
    ignore_case: bool = False

    def choice_problem(self, text: str) -> tuple[str, str] | None:
        """Return the error for a text that is not among the values."""
        shown = text.upper() if self.ignore_case else text
        if not self.values or shown in self.values:
            return None
        return f"'{self.name}' cannot be '{text}'", one_of(text, self.values)


@dataclass(frozen=True, slots=True)
class Action:
    """
    An action of the launch language.

    :param name: The key in the launch file
    :param help: What it does, in one sentence
    :param attributes: Its attributes, `if` and `unless` among them
    :param since: The first ROS 2 release that has it
    """

    name: str
    help: str
    attributes: tuple[Attribute, ...]
    since: str = 'Humble'

    def attribute(self, name: str) -> Attribute | None:
        """Return the attribute with that name, or None."""
        return by_name(self.attributes).get(name)

    @property
    def has_children(self) -> bool:
        """Whether actions stand inside of it."""
        return self.attribute('children') is not None


#: The attributes that every action has.
CONDITIONS = (
    Attribute(
        'if', Type.CONDITION, 'Run the action only if this is true or 1.'
    ),
    Attribute(
        'unless', Type.CONDITION, 'Run the action only if this is false or 0.'
    ),
)
_CHILDREN = Attribute(
    'children', Type.ACTIONS, 'The actions inside, in order.', required=True
)


def _required(name: str, kind: Type, text: str) -> Attribute:
    return Attribute(name, kind, text, required=True)


def _text(name: str, text: str) -> Attribute:
    return Attribute(name, Type.TEXT, text)


def _name(name: str, text: str, pattern: str | None = None) -> Attribute:
    return Attribute(name, Type.NAME, text, pattern=pattern)


def _items(
    name: str,
    text: str,
    items: tuple[Attribute, ...],
    since: str | None = None,
) -> Attribute:
    return Attribute(name, Type.ITEMS, text, items=items, since=since)


def _flag(
    name: str, text: str, default: str, since: str | None = None
) -> Attribute:
    return Attribute(name, Type.BOOLEAN, text, default=default, since=since)


# rmw's rules for names, as `node_name_problem` of `node_names` checks
_NODE_NAME_PATTERN = '[A-Za-z_][A-Za-z0-9_]*'
_NAMESPACE_PATTERN = (
    '/*|/?[A-Za-z_~{}][A-Za-z0-9_~{}]*(/[A-Za-z_~{}][A-Za-z0-9_~{}]*)*/*'
)


def _pair(name: str) -> tuple[Attribute, ...]:
    return (
        _required('name', Type.NAME, name),
        _required('value', Type.TEXT, 'The value.'),
    )


_VARIABLE = _pair('The name of the environment variable.')
_CONFIGURATION = _pair('The name of the launch configuration.')
_REMAP = (
    _required('from', Type.NAME, 'The name that the node uses.'),
    _required('to', Type.NAME, 'The name to use instead.'),
)
#: The types of a parameter that is no list.
SCALAR_TYPES = ('str', 'bool', 'int', 'float')
_LIST_TYPES = tuple(f'list_of_{kind}' for kind in SCALAR_TYPES)


@dataclass(frozen=True, slots=True)
class _NestedParameters(Attribute):
    """The attribute whose items have the attributes of their parent."""


PARAMETER: tuple[Attribute, ...] = (
    _text(
        'name',
        "The name of the parameter; required unless there is a 'from'.",
    ),
    Attribute(
        'value',
        Type.VALUE,
        'The value; a text with substitutions is read as YAML after '
        "substitution, unless there is a 'type'.",
    ),
    Attribute(
        'type',
        Type.PLAIN,
        'The type that the value must have, or is converted to after '
        'substitution.',
        values=(*SCALAR_TYPES, *_LIST_TYPES, 'yaml'),
    ),
    _text(
        'from',
        'A YAML file with parameters; use it alone or with allow_substs.',
    ),
    _flag(
        'allow_substs',
        "Evaluate substitutions in the file of 'from'.",
        'false',
    ),
    _NestedParameters(
        'param',
        Type.ITEMS,
        'Parameters whose names start with this name and a dot; use them '
        "instead of 'value'.",
    ),
)

_PROCESS = (
    _text(
        'cwd',
        'The working directory; the default is the folder in which the '
        'launch was started.',
    ),
    _items(
        'env',
        "Environment variables for this process, in addition to the scope's.",
        _VARIABLE,
    ),
    Attribute(
        'output',
        Type.TEXT,
        'Where the output goes: to the screen and the log (both), to one of '
        'them, to separate log files (own_log), or to all of these (full).',
        values=OUTPUT_MODES,
        default=OUTPUT_MODES[0],
    ),
    _text(
        'launch-prefix',
        'A command that runs the process, such as `gdb -ex run --args`.',
    ),
    Attribute(
        'on_exit',
        Type.PLAIN,
        'End the whole launch when this process ends.',
        values=('shutdown',),
        since='Iron',
    ),
    _flag('respawn', 'Restart the process whenever it ends.', 'false'),
    Attribute(
        'respawn_max_retries',
        Type.INTEGER,
        'The maximum number of restarts; -1 means no limit.',
        default=str(UNLIMITED_RETRIES),
        since='Jazzy',
    ),
    Attribute(
        'respawn_delay',
        Type.SECONDS,
        'The pause before a restart.',
        default='0.0',
    ),
    Attribute(
        'sigterm_timeout',
        Type.SECONDS,
        'When stopping, the time from SIGINT to SIGTERM.',
        default=str(DEFAULT_SIGTERM_TIMEOUT),
        since='Iron',
    ),
    Attribute(
        'sigkill_timeout',
        Type.SECONDS,
        'When stopping, the time from SIGTERM to SIGKILL.',
        default=str(DEFAULT_SIGKILL_TIMEOUT),
        since='Iron',
    ),
    _flag(
        'shell',
        'Run the arguments with /bin/sh, joined by spaces and not quoted.',
        'false',
    ),
    _flag(
        'emulate_tty',
        'Give the process a terminal for its output.',
        'false',
        'Iron',
    ),
)
_NODE_PARAMETERS = (
    _items(
        'param',
        'Parameters; if several have the same name, the last one counts.',
        PARAMETER,
    ),
    _items('remap', 'Names to replace with others.', _REMAP),
)
_NODE = (
    _name(
        'pkg',
        'The package that contains the program; without it, the program is a '
        'path or is found on the PATH.',
    ),
    _required('exec', Type.NAME, 'The program.'),
    _name(
        'name',
        'The name of the node.',
        _NODE_NAME_PATTERN,
    ),
    _name(
        'exec_name',
        'The name of the process in the output if the node has no name; the '
        'default is the name of the program.',
    ),
    _name(
        'namespace',
        'The namespace of the node; a relative one is appended to that of '
        'the scope.',
        _NAMESPACE_PATTERN,
    ),
    Attribute('args', Type.COMMAND, 'Arguments for the program.'),
    Attribute('ros_args', Type.COMMAND, 'Arguments after --ros-args.'),
    *_NODE_PARAMETERS,
    *_PROCESS,
)
_AUTOSTART = _flag(
    'autostart',
    'Configure and activate the node once it is running.',
    'false',
)
_COMPONENT = (
    _required('pkg', Type.NAME, 'The package that contains the plugin.'),
    _required(
        'plugin',
        Type.NAME,
        'The class of the node, as the package registers it.',
    ),
    _name(
        'name',
        'The name of the node; the default is the one that the node sets '
        'itself.',
        _NODE_NAME_PATTERN,
    ),
    _name(
        'namespace',
        'The namespace of the node; a relative one is appended to that of '
        'the scope, not of the container.',
        _NAMESPACE_PATTERN,
    ),
    *_NODE_PARAMETERS,
    _items(
        'extra_arg',
        'More arguments for the container, such as use_intra_process_comms.',
        (
            _required('name', Type.NAME, 'The name of the argument.'),
            _required('value', Type.VALUE, 'The value, read as YAML.'),
        ),
    ),
)
_TIMER = (
    _required('period', Type.SECONDS, 'The time to wait.'),
    _CHILDREN,
    _flag(
        'cancel_on_shutdown',
        'Whether the launch drops the timer when it ends, instead of waiting '
        'for it.',
        'true',
    ),
)
_LOG = (_required('message', Type.TEXT, 'The text to show.'),)
_ARGUMENT = (
    _required('name', Type.PLAIN, 'The name of the argument.'),
    _text(
        'default',
        'The value if none is given; without a default, the argument is '
        'required.',
    ),
    Attribute(
        'description', Type.PLAIN, 'A description, which --show-args prints.'
    ),
)


def _action(
    name: str, text: str, *attributes: Attribute, since: str = 'Humble'
) -> Action:
    return Action(name, text, (*attributes, *CONDITIONS), since)


#: What stands in the lists of actions that load components: each item is
#: done like an action, so that it may have conditions.
COMPONENTS = {
    action.name: action
    for action in (
        _action(
            'composable_node',
            'Load a component into the container.',
            *_COMPONENT,
        ),
        _action(
            'composable_lifecycle_node',
            'Load a component that is a lifecycle node into the container.',
            *_COMPONENT,
            _AUTOSTART,
            since='Lyrical',
        ),
    )
}
_COMPONENT_LISTS = tuple(
    _items(
        action.name,
        text,
        action.attributes,
        None if action.since == RELEASES[0] else action.since,
    )
    for action, text in zip(
        COMPONENTS.values(),
        (
            'Components to load, one after the other.',
            'Lifecycle nodes to load as components.',
        ),
        strict=True,
    )
)

_ACTIONS = (
    _action(
        'arg',
        'Declare a launch argument, which the command line or an include can '
        'set.',
        *_ARGUMENT,
        _items(
            'choice',
            'The allowed values.',
            (_required('value', Type.PLAIN, 'An allowed value.'),),
        ),
    ),
    _action(
        'bool_arg',
        'Declare a launch argument that is true or false.',
        *_ARGUMENT,
        since='Lyrical',
    ),
    _action(
        'let',
        'Set a launch configuration, which $(var name) reads.',
        *_CONFIGURATION,
    ),
    _action(
        'reset',
        'Clear all launch configurations, and the namespace, parameters and '
        'remappings of the scope.',
        _items(
            'keep', 'Launch configurations to set afterwards.', _CONFIGURATION
        ),
    ),
    _action(
        'set_env',
        'Set an environment variable for the following actions.',
        *_VARIABLE,
    ),
    _action(
        'unset_env',
        'Remove an environment variable for the following actions.',
        _required('name', Type.NAME, 'The name of the environment variable.'),
    ),
    _action(
        'append_env',
        'Append to an environment variable, or set it if it does not exist.',
        *_VARIABLE,
        _flag('prepend', 'Prepend the value instead.', 'false'),
        Attribute(
            'separator',
            Type.TEXT,
            'The text between the old value and the new one.',
            default=':',
        ),
    ),
    _action(
        'reset_env',
        'Undo all changes that the launch files made to the environment.',
    ),
    _action(
        'log',
        'Show a message and write it to the log.',
        *_LOG,
        Attribute(
            'level',
            Type.TEXT,
            'The severity.',
            values=(
                'DEBUG',
                'INFO',
                'WARNING',
                'ERROR',
                'FATAL',
                'WARN',
                'CRITICAL',
                'NOTSET',
            ),
            default='INFO',
            since='Lyrical',
            ignore_case=True,
        ),
    ),
    _action('log_info', 'Show a message.', *_LOG, since='Lyrical'),
    _action('log_warning', 'Show a warning.', *_LOG, since='Lyrical'),
    _action('log_error', 'Show an error.', *_LOG, since='Lyrical'),
    _action('log_debug', 'Show a debug message.', *_LOG, since='Lyrical'),
    _action(
        'shutdown',
        'End the launch: stop all processes.',
        Attribute('reason', Type.TEXT, 'The reason, for readers of the log.'),
    ),
    _action(
        'group',
        'Run several actions in their own scope.',
        _CHILDREN,
        _flag('scoped', 'Whether their settings end with the group.', 'true'),
        _flag(
            'forwarding',
            'Whether they see the settings from before the group.',
            'true',
        ),
        _items('keep', 'Launch configurations to set first.', _CONFIGURATION),
    ),
    _action(
        'timer',
        'Run several actions once, some time after the launch has reached '
        'them.',
        *_TIMER,
    ),
    _action(
        'ros_timer',
        'Run several actions once, some time after the launch has reached '
        "them; the time is that of the topic /clock if 'set_use_sim_time' is "
        'true.',
        *_TIMER,
    ),
    _action(
        'for_each',
        'Repeat several actions for each of the given values.',
        _required(
            'values',
            Type.TEXT,
            'YAML mappings of names to values, separated by semicolons.',
        ),
        _CHILDREN,
        since='Kilted',
    ),
    _action(
        'for',
        'Repeat several actions a given number of times.',
        _required('len', Type.INTEGER, 'The number of times.'),
        _required(
            'name', Type.PLAIN, 'The name of the index, which counts from 0.'
        ),
        _CHILDREN,
        since='Kilted',
    ),
    _action(
        'include',
        'Run all actions of another launch file in the same scope.',
        _required(
            'file',
            Type.TEXT,
            'The launch file, in YAML, XML or Python; a relative path is '
            'looked up in the folder in which the launch was started, then '
            'in the folder of this file.',
        ),
        _items('arg', 'Launch arguments for the file.', _pair('The name.')),
        _items('let', "The same as 'arg'.", _pair('The name.'), 'Jazzy'),
    ),
    _action(
        'executable',
        'Run a program.',
        _required('cmd', Type.COMMAND, 'The command line.'),
        _name(
            'name',
            'The name of the process in the output; the default is the name '
            'of the program.',
        ),
        *_PROCESS,
    ),
    _action('node', 'Run a ROS node.', *_NODE),
    _action(
        'node_container',
        'Run a component container and load components into it; ROS 2 '
        'requires a name and a namespace.',
        *_NODE,
        *_COMPONENT_LISTS,
    ),
    _action(
        'load_composable_node',
        'Load components into a running container, no matter who started it.',
        _required(
            'target',
            Type.NAME,
            "The full name of the container's node; you may omit the first "
            'slash.',
        ),
        *_COMPONENT_LISTS,
    ),
    _action(
        'lifecycle_node',
        'Run a lifecycle node; ROS 2 requires a namespace.',
        *(
            # those of a node are all older than this
            replace(a, required=a.required or a.name == 'name', since=None)
            for a in _NODE
        ),
        _AUTOSTART,
        since='Lyrical',
    ),
    _action(
        'push_ros_namespace',
        'Put the following nodes in the scope into a namespace.',
        Attribute(
            'namespace',
            Type.NAME,
            'The namespace; a relative one is appended to that of the scope.',
            required=True,
            pattern=_NAMESPACE_PATTERN,
        ),
    ),
    _action(
        'set_parameter',
        'Set a parameter for the following nodes in the scope.',
        _required('name', Type.NAME, 'The name of the parameter.'),
        _required('value', Type.VALUE, 'The value.'),
    ),
    _action(
        'set_parameters_from_file',
        'Set parameters from a file for the following nodes in the scope.',
        _required('filename', Type.TEXT, 'A YAML file with parameters.'),
    ),
    _action(
        'set_remap',
        'Remap a name for the following nodes in the scope.',
        *_REMAP,
    ),
    _action(
        'set_use_sim_time',
        "Let the following nodes and 'ros_timer' actions in the scope use "
        'simulated time.',
        _required('value', Type.BOOLEAN, 'Whether they use simulated time.'),
    ),
    _action(
        'set_ros_log_dir',
        'Set the log folder for the following nodes in the scope.',
        _required(
            'new_log_dir',
            Type.TEXT,
            'The folder; a relative one is appended to the current one.',
        ),
        since='Iron',
    ),
)

#: All actions by name.
ACTIONS = {action.name: action for action in _ACTIONS}
#: Other spellings of an action's name.
ALIASES = {'push-ros-namespace': 'push_ros_namespace'}


def items_of(attribute: Attribute) -> tuple[Attribute, ...]:
    """Return the attributes of each item of a list."""
    if isinstance(attribute, _NestedParameters):
        return PARAMETER
    return attribute.items


_BY_NAME: dict[int, tuple[object, dict[str, Attribute], list[str]]] = {}


def by_name(attributes: tuple[Attribute, ...]) -> Mapping[str, Attribute]:
    """Return attributes by their names; the same for the same attributes."""
    return _names(attributes)[1]


def required_of(attributes: tuple[Attribute, ...]) -> Sequence[str]:
    """Return the names of the attributes that there must be."""
    return _names(attributes)[2]


def _names(
    attributes: tuple[Attribute, ...],
) -> tuple[object, dict[str, Attribute], list[str]]:
    found = _BY_NAME.get(id(attributes))
    if found is None:
        # with the attributes themselves, so that no others get their id
        found = _BY_NAME[id(attributes)] = (
            attributes,
            {a.name: a for a in attributes},
            [a.name for a in attributes if a.required],
        )
    return found
