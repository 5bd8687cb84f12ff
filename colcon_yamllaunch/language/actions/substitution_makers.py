# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What makes the substitutions.

To add a substitution is to add an entry to the table of substitutions, and a
function here: to :data:`_TEXTS` if it makes a text of texts, to :data:`_NAMES`
if it looks up a name.
"""

from collections.abc import Callable, Mapping
import math
import os
from pathlib import Path
import platform
import random
import re
import shlex
import shutil

from colcon_yamllaunch.common.files import content_of
from colcon_yamllaunch.common.suggestions import did_you_mean, is_slip
from colcon_yamllaunch.language.evaluation.call import Call, Maker
from colcon_yamllaunch.language.evaluation.scope import (
    ANY_NAME,
    derived,
    known,
    LeftOpen,
    unknown,
    Value,
)
from colcon_yamllaunch.language.syntax.diagnostics import error, LaunchError
from colcon_yamllaunch.language.vocabulary.parameter import parse_boolean

#: The largest file that `$(file-content …)` reads (bytes).
MAXIMUM_CONTENT = 16 * 1024 * 1024
#: How many characters of an expression a message shows.
MAXIMUM_SHOWN = 500
#: The ways of `$(command …)` with output on stderr, as ROS 2 names them.
STDERR_MODES = ('fail', 'ignore', 'warn', 'capture')

# returns None for what only a launch can know
TextMaker = Callable[..., str | bool | None]
NameMaker = Callable[[Call, str], Value]


def _of_texts(make: TextMaker) -> Maker:
    """Return what makes a value, from what makes a text of known texts."""

    def make_value(call: Call) -> Value:
        values = call.all()
        texts = [value.text for value in values]
        text: str | None = None
        if call.walk.is_launch and any(value.sources for value in values):
            # it is made of what the plan leaves open
            words = ' '.join(shlex.quote(text or '') for text in texts)
            text = LeftOpen(f'$({call.name} {words})')
        elif None not in texts:
            try:
                made = make(call, *texts)
                text = str(made).lower() if isinstance(made, bool) else made
                if text is not None:
                    call.walk.budget.spend(len(text), lambda: call.position)
            except LaunchError as e:
                call.walk.fail(e)
        if isinstance(text, LeftOpen):
            return Value(text, text, frozenset((text,)))
        if call.walk.is_launch and text is not None:
            return derived(text, text, values)
        return call.walk.settled(derived(text, call.key(values), values))

    return make_value


def _of_name(make: NameMaker) -> Maker:
    """Return what makes a value, from what looks a name up."""

    def make_value(call: Call) -> Value:
        name = call.text(0)
        return call.unknown(call.all()) if name is None else make(call, name)

    return make_value


def _boolean(call: Call, text: str) -> bool:
    value = parse_boolean(text)
    if value is None:
        raise error(f"'{text}' is neither true nor false", call)
    return value


def _var(call: Call, name: str) -> Value:
    walk = call.walk
    walk.read.add(name)
    configurations = walk.scope.configurations
    value = configurations.get(name)
    if value is not None:
        if walk.given.get(name) is value:
            walk.given_read.add(name)
        return value if value.text is not None else walk.settled(value)
    source = f'$(var {name})'
    if len(call) > 1:
        return walk.default(call[1], source)
    if not walk.may_be_set(name):
        names = configurations.all()
        walk.fail(
            error(
                f"launch configuration '{name}' does not exist",
                call,
                hint=did_you_mean(name, names)
                or f"declare it with 'arg' or set it with 'let' before this, "
                f'or give a default: $(var {name} default)',
            ),
            # who wants what is off by default may be to provide it
            is_certain=walk.is_on_by_default or is_slip(name, names),
        )
    return unknown(source)


def _env(call: Call, name: str) -> Value:
    walk = call.walk
    value = walk.variable(name)
    if value is not None and value.text is not None:
        return value
    if len(call) > 1:
        default = call[1]
        if value is None and walk.has_environment:
            return default
    elif value is None:
        walk.fail(
            error(
                f"environment variable '{name}' does not exist",
                call,
                hint=did_you_mean(name, walk.environment)
                or f'set it, or give a default: $(env {name} default)',
                may_pass_after_build=True,
            ),
            is_certain=False,
        )
    return walk.settled(value or unknown(f'$(env {name})'))


def _eval(call: Call, expression: str, modules: str = 'math') -> str | None:
    # most launch files compute nothing
    from colcon_yamllaunch.language.actions import expressions

    value = None
    try:
        if call.walk.runs:
            return expressions.run(call.walk, expression, modules)
        if modules == 'math':
            value = expressions.compute(expression)
    except expressions.ExpressionError as e:
        shown = expression
        if len(shown) > MAXIMUM_SHOWN:
            shown = f'{shown[:MAXIMUM_SHOWN]}…'
        raise error(f"the expression '{shown}' fails: {e}", call) from e
    if value is None and call.walk.is_launch:
        return call.walk.leave_open(
            f'$(eval {shlex.quote(expression)})', call.position
        )
    return value


def _command(call: Call, line: str, mode: str = 'fail') -> str | None:
    if mode not in STDERR_MODES:
        raise error(
            f"'{mode}' is no way to treat output on stderr",
            call,
            hint=f'it is one of {", ".join(STDERR_MODES)}',
        )
    try:
        words = shlex.split(line)
    except ValueError as e:
        raise error(f"the command '{line}' has an open quote", call) from e
    if not words:
        raise error('the command is empty', call)
    walk = call.walk
    if not walk.is_launch:
        return None
    if not walk.runs:
        return walk.leave_open(
            f'$(command {shlex.quote(line)})', call.position
        )
    # most launch files run none
    from colcon_yamllaunch.language.actions.commands import run_command

    return run_command(call, line, words, mode)


def _find_exec(call: Call, name: str) -> str | None:
    path = call.walk.search_path()
    if path is None:
        return None
    found = shutil.which(name, path=path)
    if found is None:
        raise error(
            call.walk.no_program(name), call, may_pass_after_build=True
        )
    return found


def _find_pkg_prefix(call: Call, name: str) -> str:
    walk = call.walk
    prefix = walk.packages.prefix(name)
    if prefix is None:
        message, hint = walk.no_package(name)
        raise error(message, call, hint=hint)
    walk.use_package(name, call.position)
    return prefix


def _exec_in_pkg(call: Call, name: str, package: str) -> str:
    _find_pkg_prefix(call, package)
    packages = call.walk.packages
    found = packages.executable(package, name)
    if found is None:
        raise error(packages.explain_executable(package, name), call)
    return found


def _anon(call: Call, name: str) -> str | None:
    if not call.walk.is_launch:
        return None
    configurations = call.walk.scope.configurations
    key = f'anon{name}'
    value = configurations.get(key)
    if value is not None:
        return value.text
    number = random.getrandbits(64)
    unique = f'{name}_{platform.node()}_{os.getpid()}_{number}'
    unique = re.sub('[.:-]', '_', unique)
    configurations.set(key, known(unique))
    return unique


def _this_file(call: Call) -> str:
    path = call.walk.source.name
    if call.name == 'dirname':
        path = os.path.dirname(path)
    call.walk.name_place(call, path)
    return path


def _file_content(call: Call, name: str) -> str | None:
    walk = call.walk
    path = Path(walk.cwd, name)
    walk.inputs[str(path)] = None
    try:
        text = content_of(path, MAXIMUM_CONTENT).decode('utf-8')
    except (OSError, ValueError) as e:
        may_appear = walk.packages.may_appear(str(path))
        if may_appear and not walk.is_launch:
            return None
        reason = getattr(e, 'strerror', None) or 'it is not UTF-8 text'
        raise error(
            f"cannot read '{path}': {reason}",
            call,
            may_pass_after_build=may_appear,
        ) from e
    # as in files that are opened as texts
    return text.replace('\r\n', '\n').replace('\r', '\n')


def _all(call: Call, *texts: str) -> bool:
    # each of them must be a boolean
    return False not in [_boolean(call, text) for text in texts]


def _any(call: Call, *texts: str) -> bool:
    return True in [_boolean(call, text) for text in texts]


def _is_equal(left: str, right: str) -> bool:
    booleans = ('true', '1', 'false', '0')
    if left.lower() in booleans and right.lower() in booleans:
        true = ('true', '1')
        return (left.lower() in true) == (right.lower() in true)
    try:
        return math.isclose(float(left), float(right))
    except ValueError:
        return left == right


def _if(call: Call) -> Value:
    condition = call[0]
    if condition.text is None:
        return call.unknown([condition, *call.all()[1:]])
    try:
        is_true = _boolean(call, condition.text)
    except LaunchError as e:
        call.walk.fail(e)
        return condition.forgotten()
    side = known('')
    if is_true or len(call) > 2:
        side = call[1] if is_true else call[2]
    both = [condition, side]
    return call.walk.settled(derived(side.text, call.key(both), both))


def _param(call: Call, name: str) -> Value:
    walk = call.walk
    for parameter in walk.scope.parameters:
        if not isinstance(parameter, str) and parameter.name in (
            name,
            ANY_NAME,
        ):
            if walk.is_launch:
                return known(str(parameter.value))
            return call.unknown(call.all())
    if walk.scope.configurations.may_have_others():
        return call.unknown(call.all())
    if len(call) > 1:
        return call[1]
    walk.fail(
        error(
            f"no 'set_parameter' before this sets the parameter '{name}'",
            call,
            hint=f'give a default: $(param {name} default)',
        )
    )
    return call.unknown(call.all())


def _for_variable(call: Call, name: str) -> Value:
    variables = call.walk.scope.variables
    if name in variables:
        return variables[name]
    if len(call) > 1:
        return call[1]
    if ANY_NAME not in variables:
        text = f"no 'for_each' or 'for' around this has the variable '{name}'"
        near = did_you_mean(name, variables)
        call.walk.fail(error(text, call, hint=near))
    return call.unknown(call.all())


def _string_join(call: Call, delimiter: str, *parts: str) -> str:
    characters = len(delimiter) * len(parts) + sum(map(len, parts))
    call.walk.budget.spend(characters, lambda: call.position)
    return delimiter.join(parts)


def _exposed(call: Call, *texts: str) -> str | None:
    return call.walk.make_exposed(call.name, texts, call)


class _Makers(dict[str, Maker]):
    """The maker of each substitution; packages make all other ones."""

    def __missing__(self, _name: str) -> Maker:
        return _of_texts(_exposed)


_NAMES: Mapping[str, NameMaker] = {
    'var': _var,
    'env': _env,
    'param': _param,
    'for-var': _for_variable,
    'index': _for_variable,
}
_TEXTS: Mapping[str, TextMaker] = {
    'eval': _eval,
    'command': _command,
    'find-exec': _find_exec,
    'find-pkg-prefix': _find_pkg_prefix,
    'find-pkg-share': lambda call, name: os.path.join(
        _find_pkg_prefix(call, name), 'share', name
    ),
    'exec-in-pkg': _exec_in_pkg,
    'anon': _anon,
    'dirname': _this_file,
    'filename': _this_file,
    'log_dir': lambda call: call.walk.log_folder,
    'launch_log_dir': lambda call: call.walk.log_folder,
    'file-content': _file_content,
    'not': lambda call, text: not _boolean(call, text),
    'and': _all,
    'or': _any,
    'any': _any,
    'all': _all,
    'equals': lambda _call, *texts: _is_equal(*texts),
    'not-equals': lambda _call, *texts: not _is_equal(*texts),
    'string-join': _string_join,
    'path-join': lambda _call, *parts: str(Path(*parts)),
    'string-strip': lambda _call, text: text.strip(),
}
#: What makes each substitution.
MAKERS: Mapping[str, Maker] = _Makers(
    {
        'if': _if,
        **{name: _of_name(make) for name, make in _NAMES.items()},
        **{name: _of_texts(make) for name, make in _TEXTS.items()},
    }
)
