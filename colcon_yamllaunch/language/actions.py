# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The table of actions and their attributes.

Everything that depends on which actions there are comes from here: reading a
launch file, the types of its values, suggestions for a misspelled name. To add
an action is to add an entry here and a function in `evaluate.py`.
"""

from dataclasses import dataclass
from enum import Enum

from colcon_yamllaunch.language.plan import OUTPUT_MODES


class Type(Enum):
    """What the value of an attribute is."""

    #: text with substitutions
    TEXT = 'text'
    #: text with substitutions that names something; a YAML boolean is an
    #: error, since it is a name that was not quoted
    NAME = 'name'
    #: text without substitutions
    PLAIN = 'plain text'
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
    """

    name: str
    type: Type
    help: str
    required: bool = False
    items: 'tuple[Attribute, ...]' = ()
    values: tuple[str, ...] = ()


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
        for attribute in self.attributes:
            if attribute.name == name:
                return attribute
        return None

    @property
    def has_children(self) -> bool:
        """Whether actions stand inside of it."""
        return self.attribute('children') is not None


_CONDITIONS = (
    Attribute('if', Type.TEXT, 'Do it only when this is true.'),
    Attribute('unless', Type.TEXT, 'Do it only when this is false.'),
)
_CHILDREN = Attribute('children', Type.ACTIONS, 'The actions, in order.', True)


def _required(name: str, kind: Type, text: str) -> Attribute:
    return Attribute(name, kind, text, required=True)


_PAIR = (
    _required('name', Type.NAME, 'The name.'),
    _required('value', Type.TEXT, 'The value.'),
)
_REMAP = (
    _required('from', Type.NAME, 'The name in the node.'),
    _required('to', Type.NAME, 'The name that it gets.'),
)
_PARAMETER_TYPES = (
    'str',
    'bool',
    'int',
    'float',
    'list_of_str',
    'list_of_bool',
    'list_of_int',
    'list_of_float',
    'yaml',
)
_PARAMETER_SCALARS = (
    Attribute('name', Type.TEXT, "The parameter's name."),
    Attribute('value', Type.VALUE, "The parameter's value."),
    Attribute(
        'type', Type.PLAIN, "The value's type.", values=_PARAMETER_TYPES
    ),
    Attribute('from', Type.TEXT, 'A YAML file with parameters.'),
    Attribute(
        'allow_substs',
        Type.BOOLEAN,
        'Whether the file has substitutions to be made.',
    ),
)


@dataclass(frozen=True, slots=True)
class _NestedParameters(Attribute):
    """The attribute whose items have the attributes of their parent."""


PARAMETER: tuple[Attribute, ...] = (
    *_PARAMETER_SCALARS,
    _NestedParameters(
        'param', Type.ITEMS, 'Parameters whose names start with this one.'
    ),
)

_PROCESS = (
    Attribute('cwd', Type.TEXT, 'The working directory.'),
    Attribute(
        'env',
        Type.ITEMS,
        'Environment variables for the process.',
        items=_PAIR,
    ),
    Attribute(
        'output',
        Type.TEXT,
        'Where its output goes.',
        values=OUTPUT_MODES,
    ),
    Attribute(
        'launch-prefix',
        Type.TEXT,
        'A command that runs the process, such as `gdb -ex run --args`.',
    ),
    Attribute(
        'on_exit',
        Type.PLAIN,
        'What happens when the process ends.',
        values=('shutdown',),
    ),
    Attribute('respawn', Type.BOOLEAN, 'Whether it is started again.'),
    Attribute(
        'respawn_max_retries',
        Type.INTEGER,
        'How often at most; without end when -1.',
    ),
    Attribute('respawn_delay', Type.SECONDS, 'The pause before that.'),
    Attribute(
        'sigterm_timeout', Type.SECONDS, 'The time from SIGINT to SIGTERM.'
    ),
    Attribute(
        'sigkill_timeout', Type.SECONDS, 'The time from SIGTERM to SIGKILL.'
    ),
    Attribute('shell', Type.BOOLEAN, 'Whether /bin/sh runs the command.'),
    Attribute(
        'emulate_tty', Type.BOOLEAN, 'Whether its output is a terminal.'
    ),
)
_NODE = (
    Attribute('pkg', Type.NAME, 'The package that has the program.'),
    _required('exec', Type.NAME, 'The program.'),
    Attribute('name', Type.NAME, "The node's name."),
    Attribute('exec_name', Type.NAME, "The process's name in output."),
    Attribute('namespace', Type.NAME, "The node's namespace."),
    Attribute('args', Type.COMMAND, 'Arguments of the program.'),
    Attribute('ros_args', Type.COMMAND, 'Arguments behind --ros-args.'),
    Attribute('param', Type.ITEMS, "The node's parameters.", items=PARAMETER),
    Attribute('remap', Type.ITEMS, "The node's remappings.", items=_REMAP),
    *_PROCESS,
)
_LOG = (_required('message', Type.TEXT, 'The line.'),)


def _action(
    name: str, text: str, *attributes: Attribute, since: str = 'Humble'
) -> Action:
    return Action(name, text, (*attributes, *_CONDITIONS), since)


_ACTIONS = (
    _action(
        'arg',
        'Declare a launch argument.',
        _required('name', Type.PLAIN, 'Its name.'),
        Attribute('default', Type.TEXT, 'Its value when none is given.'),
        Attribute('description', Type.PLAIN, 'What it is for.'),
        Attribute(
            'choice',
            Type.ITEMS,
            'The values that it may have.',
            items=(_required('value', Type.PLAIN, 'One of them.'),),
        ),
    ),
    _action(
        'bool_arg',
        'Declare a launch argument that is true or false.',
        _required('name', Type.PLAIN, 'Its name.'),
        Attribute('default', Type.TEXT, 'Its value when none is given.'),
        Attribute('description', Type.PLAIN, 'What it is for.'),
        since='Lyrical',
    ),
    _action('let', 'Set a launch configuration.', *_PAIR),
    _action(
        'reset',
        'Forget all launch configurations.',
        Attribute('keep', Type.ITEMS, 'Those to set afterwards.', items=_PAIR),
    ),
    _action('set_env', 'Set an environment variable.', *_PAIR),
    _action(
        'unset_env',
        'Unset an environment variable.',
        _required('name', Type.NAME, 'Its name.'),
    ),
    _action(
        'append_env',
        'Append to an environment variable.',
        *_PAIR,
        Attribute('prepend', Type.BOOLEAN, 'Whether to put it in front.'),
        Attribute('separator', Type.TEXT, 'What stands between.'),
    ),
    _action('reset_env', 'Undo all changes to the environment.'),
    _action(
        'log',
        'Show a line.',
        *_LOG,
        Attribute('level', Type.TEXT, 'DEBUG, INFO, WARNING, ERROR or FATAL.'),
    ),
    _action('log_info', 'Show a line.', *_LOG, since='Lyrical'),
    _action('log_warning', 'Show a warning.', *_LOG, since='Lyrical'),
    _action('log_error', 'Show an error.', *_LOG, since='Lyrical'),
    _action('log_debug', 'Show a line for debugging.', *_LOG, since='Lyrical'),
    _action(
        'shutdown',
        'End the launch.',
        Attribute('reason', Type.TEXT, 'Why.'),
    ),
    _action(
        'group',
        'Do several actions in a scope of their own.',
        _CHILDREN,
        Attribute('scoped', Type.BOOLEAN, 'Whether what they set ends here.'),
        Attribute(
            'forwarding',
            Type.BOOLEAN,
            'Whether they see what was set before.',
        ),
        Attribute(
            'keep',
            Type.ITEMS,
            'Launch configurations to set first.',
            items=_PAIR,
        ),
    ),
    _action(
        'timer',
        'Do several actions later.',
        _required('period', Type.SECONDS, 'The time until then.'),
        _CHILDREN,
        Attribute(
            'cancel_on_shutdown',
            Type.BOOLEAN,
            'Whether the end of the launch drops it.',
        ),
    ),
    _action(
        'for_each',
        'Do several actions for each of some values.',
        _required(
            'values', Type.TEXT, 'YAML mappings of names to values, ; between.'
        ),
        _CHILDREN,
        since='Kilted',
    ),
    _action(
        'for',
        'Do several actions a number of times.',
        _required('len', Type.TEXT, 'How often.'),
        _required('name', Type.PLAIN, 'The name of the index.'),
        _CHILDREN,
        since='Kilted',
    ),
    _action(
        'include',
        'Run another launch file.',
        _required('file', Type.TEXT, 'The launch file.'),
        Attribute('arg', Type.ITEMS, 'Its launch arguments.', items=_PAIR),
        Attribute('let', Type.ITEMS, 'The same as arg.', items=_PAIR),
    ),
    _action(
        'executable',
        'Run a program.',
        _required('cmd', Type.COMMAND, 'The command line.'),
        Attribute('name', Type.NAME, "The process's name in output."),
        *_PROCESS,
    ),
    _action('node', 'Run a ROS node.', *_NODE),
    _action(
        'node_container',
        'Run a program that loads composable nodes.',
        *_NODE,
    ),
    _action(
        'push_ros_namespace',
        'Put the nodes that follow into a namespace.',
        _required('namespace', Type.NAME, 'The namespace.'),
    ),
    _action(
        'set_parameter',
        'Set a parameter of the nodes that follow.',
        _required('name', Type.NAME, 'Its name.'),
        _required('value', Type.VALUE, 'Its value.'),
    ),
    _action(
        'set_parameters_from_file',
        'Set parameters of the nodes that follow.',
        _required('filename', Type.TEXT, 'A YAML file with parameters.'),
    ),
    _action('set_remap', 'Remap a name in the nodes that follow.', *_REMAP),
    _action(
        'set_use_sim_time',
        'Set use_sim_time of the nodes that follow.',
        _required('value', Type.BOOLEAN, 'Whether they use simulated time.'),
    ),
    _action(
        'set_ros_log_dir',
        'Set the folder for the logs of the nodes that follow.',
        _required('new_log_dir', Type.TEXT, 'The folder.'),
    ),
)

#: All actions by name.
ACTIONS = {action.name: action for action in _ACTIONS}
#: Other spellings of an action's name.
ALIASES = {'push-ros-namespace': 'push_ros_namespace'}
#: Actions of ROS 2 that need a running ROS graph, and what to do instead.
UNSUPPORTED = {
    'lifecycle_node': "start it as a 'node' and change its state with a "
    'lifecycle manager',
    'load_composable_node': "start the node's own executable with 'node'",
    'composable_node': "start the node's own executable with 'node'",
    'ros_timer': "'timer' runs on the system's clock",
}


def items_of(attribute: Attribute) -> tuple[Attribute, ...]:
    """Return the attributes of each item of a list."""
    if isinstance(attribute, _NestedParameters):
        return PARAMETER
    return attribute.items
