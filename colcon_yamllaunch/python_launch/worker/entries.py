# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What actions of ROS 2 come to, when they only prepare what would start."""

from __future__ import annotations

from collections.abc import Callable
import contextlib
import errno
from functools import partial, wraps
import importlib
from importlib.machinery import SourceFileLoader
from importlib.metadata import entry_points
import logging
import os
from pathlib import Path
import tempfile
from typing import Any, ClassVar, TYPE_CHECKING

from .channel import Json
from .descriptions import as_json, condition_text, is_a, Private
from .errors import checked, did_you_mean, Failed, PlainError
from .imports import when_imported
from .visit import Marker

if TYPE_CHECKING:
    from .events import Events
    from .visit import Visitor


#: The attribute that keeps the `id` of what an action has started.
ID = '_launch_worker_id'
#: What launch files of ROS 2's other languages end with.
FRONTENDS = ('.yaml', '.yml', '.xml', '.launch')
#: What the files with parameters that launch_ros makes are called.
MADE_FILE = 'launch_params_'
#: Seconds of ROS 2, where an older `launch` says nothing.
DEFAULT_TIMEOUT = 5.0


class Entries:
    """
    Replaces what actions do, once their modules are imported.

    :param visitor: Reports what they come to
    :param events: Gets the actions of processes
    """

    def __init__(self, visitor: Visitor, events: Events) -> None:
        self._visitor = visitor
        self._events = events
        #: The parameters of the nodes that are being prepared, by the path of
        #: the file made for them, or as `-p` rules by None.
        self._made: dict[str | None, list[Json]] = {}
        self._files: set[str] = set()
        #: The conditions that were told, and where.
        self._conditions: set[object] = set()
        visitor.channel.at_end.append(self._remove_files)
        visitor.forget.append(self._remove_files)

    def install(self) -> None:
        """Patch what `launch` has now, and launch_ros once it is there."""
        launch = importlib.import_module('launch')
        actions = importlib.import_module('launch.actions')
        local = importlib.import_module('launch.actions.execute_local')
        note_positions(self._visitor, launch.Action)
        replace_method(local.ExecuteLocal, 'execute', self._execute)
        replace_method(actions.GroupAction, 'execute', self._group)
        replace_method(
            actions.IncludeLaunchDescription, 'execute', self._include
        )
        replace_method(launch.Condition, 'evaluate', self._evaluate)
        self._keep_loads()
        for name, do in {
            'actions.lifecycle_node': self._patch_lifecycle,
            'actions.load_composable_nodes': lambda module: replace_method(
                module.LoadComposableNodes,
                'execute',
                partial(self._load, module),
            ),
            'actions.node': self._patch_node,
            'actions.set_use_sim_time': self._patch_sim_time,
            'descriptions.composable_node': lambda module: note_positions(
                self._visitor, module.ComposableNode
            ),
            'parameter_descriptions': self._patch_files,
            'ros_adapters': self._patch_adapters,
        }.items():
            when_imported(f'launch_ros.{name}', do)

    # processes

    def _execute(self, _old: Any, action: Any, context: Any) -> None:
        visitor = self._visitor
        action.prepare(context)
        if hasattr(action, ID):
            name = action.process_description.final_name
            raise RuntimeError(
                f"ExecuteLocal action '{name}': executed more than once: "
                f'{action.describe()}'
            )
        if context.is_shutdown:
            return
        number = visitor.new_id(action)
        setattr(action, ID, number)
        on_exit = Private(action).on_exit
        shuts_down = is_shutdown(on_exit)
        visitor.say(
            'process',
            id=number,
            position=visitor.position(action),
            on_exit_shutdown=shuts_down,
            **self._process(action, context),
            **self._node(action, context),
        )
        self._events.add_process(action, number)
        if on_exit is not None and not shuts_down:
            self._events.add_on_exit(action, on_exit)

    def _process(self, action: Any, context: Any) -> Json:
        visitor = self._visitor
        description, private = action.process_description, Private(action)
        configurations = context.launch_configurations
        emulate_tty = bool(private.emulate_tty)
        if 'emulate_tty' in configurations:
            conditions = importlib.import_module('launch.conditions')
            utilities = importlib.import_module('launch.utilities')
            emulate_tty = conditions.evaluate_condition_expression(
                context,
                utilities.normalize_to_list_of_substitutions(
                    configurations['emulate_tty']
                ),
            )
        folder, here = description.final_cwd, os.getcwd()
        if here != visitor.folder:
            # the launch file went elsewhere, as what it starts does in ROS 2
            folder = os.path.join(here, folder) if folder else here
        retries = private.respawn_max_retries
        return {
            'program': description.final_name.rpartition('-')[0],
            'argv': [self._word(word) for word in description.final_cmd],
            'shell': bool(action.shell),
            'cwd': folder,
            'environment': visitor.scopes.changes(description.final_env),
            'output': self._output(private.output),
            'emulate_tty': emulate_tty,
            'respawn': bool(private.respawn),
            'respawn_delay': float(private.respawn_delay or 0.0),
            'respawn_max_retries': -1 if retries is None else int(retries),
            'sigterm_timeout': self._timeout(private.sigterm_timeout),
            'sigkill_timeout': self._timeout(private.sigkill_timeout),
        }

    def _timeout(self, value: Any) -> float:
        if value is None:
            return DEFAULT_TIMEOUT
        return float(self._visitor.text_of(value))

    def _output(self, output: Any) -> str:
        if not isinstance(output, dict):
            output = self._visitor.text_of(output)
        log = importlib.import_module('launch.logging')
        normalize = getattr(log, '_normalize_output_configuration', None)
        if normalize is not None:
            # raises ValueError for what is none
            normalized = normalize(output)
            if isinstance(output, dict):
                return nearest_mode(normalized)
        return output if isinstance(output, str) else 'both'

    def _word(self, word: str) -> Any:
        """Return a word of a command, or the content of a file made for it."""
        folder, name = os.path.split(word)
        if not name.startswith(MADE_FILE) or folder != tempfile.gettempdir():
            return self._visitor.packages.installed(word)
        try:
            with open(word, encoding='utf-8') as file:
                content = file.read()
        except OSError:
            return word
        self._files.add(word)
        return {'content': content, 'parameters': self._made.get(word, [])}

    def _remove_files(self) -> None:
        for path in self._files:
            with contextlib.suppress(OSError):
                os.unlink(path)
        self._files.clear()
        self._made.clear()
        self._conditions.clear()

    # nodes

    def _node(self, action: Any, context: Any) -> Json:
        node: Json = {
            'package': None,
            'node': None,
            'is_container': False,
            'is_lifecycle': False,
            'autostart': False,
            'parameters': [],
        }
        if not hasattr(action, 'is_node_name_fully_specified'):
            return node
        visitor = self._visitor
        package = action.node_package
        if package is not None:
            node['package'] = visitor.text_of(package)
        node['node'] = node_name(action)
        node['is_container'] = is_a(action, 'ComposableNodeContainer')
        node['is_lifecycle'] = is_a(action, 'LifecycleNode')
        node['autostart'] = _autostarts(action)
        position = visitor.position(action)
        for one in context.launch_configurations.get('global_params') or ():
            if isinstance(one, tuple):
                name, value = str(one[0]), as_json(one[1])
                node['parameters'].append(
                    {'name': name, 'value': value, 'position': position}
                )
        expanded = Private(action).expanded_parameter_arguments
        for argument, is_file in expanded or ():
            if is_file:
                node['parameters'] += self._made.get(argument, [])
            else:
                node['parameters'] += self._made.get(None, [])
                self._made.pop(None, None)
        return node

    def _patch_node(self, module: Any) -> None:
        replace_method(
            module.Node, '_create_params_file_from_dict', self._make_file
        )
        replace_method(module.Node, '_get_parameter_rule', self._make_rule)
        find = module.get_extensions

        def get_extensions(logger: Any) -> Any:
            # each node looks through all entry points that there are
            if module.g_entry_points_impl is None:
                module.g_entry_points_impl = entry_points(
                    group='launch_ros.node_action'
                )
            return find(logger)

        if hasattr(module, 'g_entry_points_impl'):
            module.get_extensions = get_extensions

    def _make_file(
        self, old: Callable[..., Any], action: Any, params: Any
    ) -> Any:
        path = old(action, params)
        self._files.add(path)
        self._made[path] = list(self._flattened(action, params, ''))
        return path

    def _make_rule(
        self, old: Callable[..., Any], action: Any, param: Any, context: Any
    ) -> Any:
        rule = old(action, param, context)
        name, value = param.evaluate(context)
        self._made.setdefault(None, []).append(
            self._parameter(action, name, value)
        )
        return rule

    def _flattened(self, action: Any, params: Any, prefix: str) -> Any:
        for name, value in params.items():
            if isinstance(value, dict):
                yield from self._flattened(action, value, f'{prefix}{name}.')
            else:
                yield self._parameter(action, f'{prefix}{name}', value)

    def _parameter(self, made: Any, name: str, value: Any) -> Json:
        return {
            'name': name,
            'value': as_json(value),
            'position': self._visitor.positions.of_parameter(made, name),
        }

    def _patch_files(self, module: Any) -> None:
        """Make ROS 2 find parameter files that are not installed yet."""
        visitor = self._visitor
        given = '_ParameterFile__param_file'
        evaluated = '_ParameterFile__evaluated_param_file'

        def evaluate(old: Callable[..., Any], file: Any, context: Any) -> Any:
            path = getattr(file, given, None)
            # several nodes may share one file, which ROS 2 evaluates once
            if path is not None and getattr(file, evaluated, None) is None:
                if not isinstance(path, (str, os.PathLike)):
                    path = visitor.text_of(path)
                # the text, so that ROS 2 does not make it once more
                path = os.fspath(path)
                setattr(file, given, Path(visitor.packages.source(path)))
            return old(file, context)

        replace_method(module.ParameterFile, 'evaluate', evaluate)

    # containers and components

    def _load(self, module: Any, _old: Any, action: Any, context: Any) -> None:
        visitor, private = self._visitor, Private(action)
        target = private.target_container
        if hasattr(target, 'is_node_name_fully_specified'):
            container = node_name(target) or target.node_name
        else:
            container = visitor.text_of(target)
        if not container.startswith('/'):
            container = f'/{container}'
        for description in private.composable_node_descriptions or ():
            request = module.get_composable_node_load_request(
                description, context
            )
            if request is None:
                continue
            position = visitor.position(description)
            visitor.packages.name(request.package_name, position)
            visitor.say(
                'component',
                container=container,
                package=request.package_name,
                plugin=request.plugin_name,
                name=request.node_name,
                namespace=request.node_namespace,
                remaps=list(request.remap_rules),
                parameters=self._messages(description, request.parameters),
                extra_arguments=self._messages(
                    description, request.extra_arguments
                ),
                is_lifecycle=is_a(description, 'ComposableLifecycleNode'),
                autostart=_autostarts(description),
                position=position,
            )

    def _messages(self, made: Any, parameters: Any) -> list[Json]:
        rclpy = importlib.import_module('rclpy.parameter')
        return [
            self._parameter(
                made, one.name, rclpy.parameter_value_to_python(one.value)
            )
            for one in parameters
        ]

    # what needs ROS itself

    def _patch_adapters(self, module: Any) -> None:
        visitor = self._visitor

        def refuse(*_args: Any, **_kwargs: Any) -> None:
            visitor.refuse('needs the ROS node')

        module.get_ros_node = refuse
        module.get_ros_adapter = refuse

    def _patch_lifecycle(self, module: Any) -> None:
        node = importlib.import_module('launch_ros.actions.node')

        def execute(_old: Any, action: Any, context: Any) -> Any:
            action._perform_substitutions(context)
            if node.Node.UNSPECIFIED_NODE_NAME in action.node_name:
                raise RuntimeError(
                    'node_name unexpectedly incomplete for lifecycle node'
                )
            return node.Node.execute(action, context)

        replace_method(module.LifecycleNode, 'execute', execute)

    def _patch_sim_time(self, module: Any) -> None:
        def execute(_old: Any, action: Any, _context: Any) -> None:
            value = action.value
            if not isinstance(value, bool):
                text = self._visitor.text_of(value)
                value = text.strip().lower() in ('true', '1', 'yes', 'on')
            self._visitor.scopes.uses_sim_time = value

        replace_method(module.SetUseSimTime, 'execute', execute)

    # what others stand in

    def _group(
        self, old: Callable[..., Any], action: Any, context: Any
    ) -> list[Any]:
        visitor = self._visitor
        title: list[str] = []
        outer = context.launch_configurations.get('ros_namespace')

        def look() -> None:
            inner = context.launch_configurations.get('ros_namespace')
            if inner != outer and inner is not None:
                title.append(f'namespace {inner}')

        children = list(old(action, context) or ())
        # the namespace is there until the group's configurations go
        is_scoped = bool(children) and (
            type(children[-1]).__name__ == 'PopLaunchConfigurations'
        )
        children.insert(len(children) - 2 * is_scoped, Marker(look))
        position = visitor.position(action)
        return [
            visitor.marker('begin', kind='group', title='', position=position),
            *children,
            # the title comes meanwhile
            Marker(lambda: visitor.say('end', title=''.join(title))),
        ]

    def _include(
        self, old: Callable[..., Any], action: Any, context: Any
    ) -> list[Any]:
        visitor = self._visitor
        source = action.launch_description_source
        private, path = Private(source), ''
        if private.launch_description is None and private.location is not None:
            path = visitor.packages.located(visitor.text_of(private.location))
        if path and os.path.splitext(path)[1] in FRONTENDS:
            self._include_frontend(action, context, path)
            return []
        if path and os.path.exists(path):
            name = '_LaunchDescriptionSource__expanded_location'
            if hasattr(source, name):
                setattr(source, name, path)
        position = visitor.position(action)
        try:
            children = old(action, context) or []
        except Exception:
            if not path or os.path.exists(path):
                raise
            text = f"the launch file '{path}' does not exist"
            # the error that led to it tells the package
            cause = FileNotFoundError(errno.ENOENT, text, path)
            hint = None
            folder, name = os.path.split(path)
            with contextlib.suppress(OSError):
                hint = did_you_mean(name, os.listdir(folder))
            raise PlainError(text, position, hint=hint) from cause
        kind = 'file' if path else 'group'
        return [
            visitor.marker('begin', kind=kind, title=path, position=position),
            *children,
            visitor.marker('end'),
        ]

    def _include_frontend(self, action: Any, context: Any, path: str) -> None:
        visitor = self._visitor
        for name, value in action.launch_arguments:
            text = visitor.text_of(value)
            context.launch_configurations[visitor.text_of(name)] = text
        answer = visitor.ask(
            'include',
            path=path,
            scope=visitor.scopes.current(),
            position=visitor.position(action),
        )
        if answer.get('failed'):
            raise Failed
        visitor.scopes.enter(answer.get('scope') or {})
        # as `launch` has it, also for those behind the include
        visitor.enter_file(path)

    # what is reported at once

    def _evaluate(
        self, old: Callable[..., Any], condition: Any, context: Any
    ) -> Any:
        taken = old(condition, context)
        position = self._visitor.position()
        # those of components are evaluated twice
        key = (id(condition), tuple(position or ()))
        if key not in self._conditions:
            self._conditions.add(key)
            self._visitor.say(
                'condition',
                text=condition_text(condition),
                taken=bool(taken),
                position=position,
            )
        return taken

    def _keep_loads(self) -> None:
        """Report the modules that launch files in Python load."""
        visitor = self._visitor
        module: Any = importlib.import_module(
            'launch.launch_description_sources.python_launch_file_utilities'
        )
        load = module.load_python_launch_file_as_module

        @wraps(load)
        def told(path: str) -> Any:
            # one with another name may turn out to be no Python
            loaded = None if path.endswith('.py') else load(path)
            visitor.positions.add_file(path)
            visitor.say('file', path=os.path.abspath(path))
            loaded = loaded or load(path)
            checked(loaded, path, visitor.positions)
            return loaded

        module.load_python_launch_file_as_module = told
        module.SourceFileLoader = _Loader
        sources: Any = importlib.import_module(
            'launch.launch_description_sources'
        )
        for name in ('Any', 'Frontend'):
            replace_method(
                getattr(sources, f'{name}LaunchDescriptionSource'),
                '_get_launch_description',
                self._describe,
            )

    def _describe(
        self, old: Callable[..., Any], source: Any, location: str
    ) -> Any:
        """Describe an included file, which may be only for its arguments."""
        is_ours = os.path.splitext(location)[1] in FRONTENDS
        if is_ours and not self._visitor.reads_frontends:
            # the launcher reads it when its turn comes
            return importlib.import_module('launch').LaunchDescription()
        return old(source, location)


def note_positions(visitor: Visitor, cls: Any) -> None:
    """Note where in the user's files objects of a class are made."""

    def init(
        old: Callable[..., Any], made: Any, *args: Any, **kwargs: Any
    ) -> None:
        visitor.positions.note(made)
        visitor.positions.pass_on(visitor.entity, made)
        old(made, *args, **kwargs)

    replace_method(cls, '__init__', init)


def replace_method(cls: Any, name: str, by: Callable[..., Any]) -> None:
    """Replace a method of a class; `by` gets the old one before all else."""
    old: Callable[..., Any] = getattr(cls, name)

    @wraps(old)
    def new(*args: Any, **kwargs: Any) -> Any:
        return by(old, *args, **kwargs)

    setattr(cls, name, new)


class _Loader(SourceFileLoader):
    """
    Loads launch files, and leaves no compiled file beside them.

    `launch` loads a file again for each include, and for its arguments.
    """

    _compiled: ClassVar[dict[tuple[Any, Any], Any]] = {}

    def set_data(self, *args: Any, **kwargs: Any) -> None:
        """Write nothing."""

    def source_to_code(self, data: Any, path: Any, **kwargs: Any) -> Any:  # type: ignore[override]
        """Compile a file, unless the same text was compiled before."""
        if (path, data) not in self._compiled:
            code = super().source_to_code(data, path, **kwargs)
            self._compiled[path, data] = code
        return self._compiled[path, data]


class MessageHandler(logging.Handler):
    """Makes messages of what `launch`, and launch files by it, log."""

    def __init__(self, visitor: Visitor) -> None:
        super().__init__()
        self._visitor = visitor

    def emit(self, record: logging.LogRecord) -> None:
        """Report a log record."""
        text = record.getMessage()
        visitor = self._visitor
        if visitor.positions.is_users(record.pathname) or (
            record.name == 'launch.user'
        ):
            visitor.say('message', level=record.levelname, text=text)
        elif record.levelno >= logging.ERROR:
            visitor.logged.append((record.levelname, text))
        elif record.levelno >= logging.WARNING:
            visitor.say('warning', text=text, position=visitor.position())
        else:
            visitor.say('message', level=record.levelname, text=text)

    def setFormatterFor(self, *_: object) -> None:  # noqa: N802 - launch's
        """Set a format, as the handlers of `launch` do."""


def install_logging(visitor: Visitor) -> None:
    """Report what `launch` logs, and write no log files."""
    log = importlib.import_module('launch.logging')
    handler = MessageHandler(visitor)
    config = log.launch_config
    config.screen_handler = handler
    config.get_screen_handler = lambda: handler
    # the same one: it is added once
    config.get_log_file_handler = lambda *_: handler


def node_name(action: Any) -> str | None:
    """Return the full name of a node as far as it is known."""
    name: str = action.node_name
    if action.UNSPECIFIED_NODE_NAME in name:
        return None
    unspecified = action.UNSPECIFIED_NODE_NAMESPACE
    if name.startswith((unspecified, f'/{unspecified}')):
        return '/' + name.rpartition('/')[2]
    return name


def nearest_mode(destinations: dict[str, set[str]]) -> str:
    """
    Return the mode of output that is nearest to the destinations given.

    :param destinations: `screen`, `log`, `own_log` for `both`, `stdout` and
      `stderr`
    """
    both = destinations.get('both', set())
    stdout = both | destinations.get('stdout', set())
    stderr = both | destinations.get('stderr', set())
    if 'screen' in stdout:
        if 'own_log' in stdout | stderr:
            return 'full'
        return 'both' if 'log' in stdout | stderr else 'screen'
    return 'log' if 'screen' in stderr else 'own_log'


def is_shutdown(on_exit: Any) -> bool:
    """Return whether the actions at the end only shut down."""
    if on_exit is None:
        return False
    actions = on_exit if isinstance(on_exit, (list, tuple)) else [on_exit]
    return bool(actions) and all(
        type(action).__name__ in ('Shutdown', 'EmitEvent')
        # some give the event itself
        and type(getattr(action, 'event', action)).__name__ == 'Shutdown'
        and getattr(action, 'condition', None) is None
        for action in actions
    )


def _autostarts(made: Any) -> bool:
    """Return whether a lifecycle node is activated; from Lyrical on."""
    value = getattr(made, 'node_autostart', None) or Private(made).autostart
    return str(value).lower() in ('true', '1')
