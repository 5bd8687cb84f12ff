# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The texts of launch files as far as they are known before a launch."""

from collections.abc import Callable
from collections.abc import Mapping
import os

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.suggestions import did_you_mean
from colcon_yamllaunch.language.checking.check_state import Checking
from colcon_yamllaunch.language.checking.expression import compute
from colcon_yamllaunch.language.checking.expression import ExpressionError
from colcon_yamllaunch.language.checking.possible_scope import known
from colcon_yamllaunch.language.checking.possible_scope import shortened
from colcon_yamllaunch.language.checking.possible_scope import unknown
from colcon_yamllaunch.language.checking.possible_scope import Value
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.position import Position
from colcon_yamllaunch.language.syntax.template import Substitution
from colcon_yamllaunch.language.syntax.template import Template
from colcon_yamllaunch.language.tree.text import Text
from colcon_yamllaunch.language.vocabulary.substitutions import (
    evaluate_template,
)
from colcon_yamllaunch.language.vocabulary.substitutions import parse_boolean

#: The longest text that is computed, in characters.
MAXIMUM_TEXT_LENGTH = 1_000_000


def value_of(checking: Checking, text: Text) -> Value:
    """Return what is known of a text, and report what cannot be had."""
    literal = text.template.literal
    if literal is not None:
        return Value(literal, literal)
    return value_of_part(checking, text, text.template)


def value_of_part(checking: Checking, text: Text, template: Template) -> Value:
    """Return what is known of a piece of a text."""
    return _template(checking, template, text.position_at)


def _template(
    checking: Checking,
    template: Template,
    position_at: Callable[[int], Position],
) -> Value:
    values = [
        known(part)
        if isinstance(part, str)
        else _substitution(_Call(checking, part, position_at))
        for part in template.parts
    ]
    return values[0] if len(values) == 1 else _joined(values)


def _joined(values: list[Value]) -> Value:
    texts = [value.text for value in values if value.text is not None]
    sources = frozenset().union(*(value.sources for value in values))
    key = shortened(''.join(value.key for value in values))
    if len(texts) < len(values) or sum(map(len, texts)) > MAXIMUM_TEXT_LENGTH:
        return Value(None, key, sources or frozenset((key,)))
    return Value(''.join(texts), key, sources)


@dataclass(frozen=True, slots=True)
class _Call:
    """A substitution, and what it may look at."""

    checking: Checking
    substitution: Substitution
    position_at: Callable[[int], Position]

    def __len__(self) -> int:
        return len(self.substitution.arguments)

    def __getitem__(self, index: int) -> Value:
        template = self.substitution.arguments[index]
        return _template(self.checking, template, self.position_at)

    def values(self) -> list[Value]:
        return [self[index] for index in range(len(self))]

    def error(self, message: str, hint: str | None = None) -> None:
        self._note(self.checking.error, message, hint)

    def warn(self, message: str, hint: str | None = None) -> None:
        self._note(self.checking.warn, message, hint)

    def _note(
        self, note: Callable[..., None], message: str, hint: str | None
    ) -> None:
        start, end = self.substitution.start, self.substitution.end
        note(message, self.position_at(start), hint=hint, length=end - start)

    def key(self, values: list[Value]) -> str:
        words = ' '.join(value.key for value in values)
        return shortened(f'$({self.substitution.name} {words})')


def _substitution(call: _Call) -> Value:
    special = _SPECIAL.get(call.substitution.name)
    if special is not None:
        return special(call)
    return _pure(call)


def _pure(call: _Call) -> Value:
    """Make a substitution as a launch does, if all it needs is known."""
    values = call.values()
    key = call.key(values)
    sources = frozenset().union(*(value.sources for value in values))
    texts = [value.text for value in values if value.text is not None]
    text = None
    if len(texts) == len(values):
        text = _made(call, texts)
    if text is None:
        return unknown(key, sources or {key})
    return Value(text, text if not sources else key, sources)


def _made(call: _Call, texts: list[str]) -> str | None:
    original = call.substitution
    substitution = Substitution(
        original.name,
        tuple(Template((text,)) for text in texts),
        original.start,
        original.end,
    )
    checking = call.checking
    template = Template((substitution,))
    try:
        return evaluate_template(template, checking.state, call.position_at)
    except LaunchError as e:
        is_missing_file = original.name == 'file-content'
        if not (is_missing_file and e.diagnostics[0].may_pass_after_build):
            checking.report(e)
        return None


def _var(call: _Call) -> Value:
    name = call[0].text
    if name is None:
        return _unknown(call)
    configurations = call.checking.scope.configurations
    binding = configurations.get(name)
    if binding is not None:
        return binding.value
    if len(call) > 1:
        return _overridable(call[1], f'$(var {name})')
    if not configurations.may_have_others():
        call.error(
            f"launch configuration '{name}' does not exist",
            did_you_mean(name, configurations.names())
            or f"declare it with 'arg' or set it with 'let' before this, or "
            f'give a default: $(var {name} default)',
        )
    return unknown(f'$(var {name})', {f'$(var {name})'})


def _overridable(value: Value, source: str) -> Value:
    """Return a default: what is used when nobody gives another value."""
    return Value(value.text, source, value.sources | {source})


def _env(call: _Call) -> Value:
    name = call[0].text
    if name is None:
        return _unknown(call)
    checking = call.checking
    binding = checking.scope.environment.get(name)
    if binding is not None:
        return binding.value
    if len(call) > 1:
        call[1]
    elif name not in checking.environment:
        call.warn(
            f"environment variable '{name}' does not exist here",
            f'set it, or give a default: $(env {name} default)',
        )
    return unknown(f'$(env {name})', {f'$(env {name})'})


def _eval(call: _Call) -> Value:
    values = call.values()
    key = call.key(values)
    sources = frozenset().union(*(value.sources for value in values))
    expression = values[0].text
    result = None
    if expression is not None and len(values) == 1:
        try:
            result = compute(expression)
        except ExpressionError as e:
            call.error(f"the expression '{expression}' fails: {e}")
    if result is None:
        return unknown(key, sources or {key})
    return Value(result, result if not sources else key, sources)


def _unknown(call: _Call) -> Value:
    values = call.values()
    key = call.key(values)
    return unknown(key, {key}.union(*(value.sources for value in values)))


def _if(call: _Call) -> Value:
    condition = call[0]
    if condition.text is None:
        sides = [call[index] for index in range(1, len(call))]
        sources = condition.sources.union(*(side.sources for side in sides))
        return unknown(call.key([condition, *sides]), sources)
    is_true = parse_boolean(condition.text)
    if is_true is None:
        call.error(f"'{condition.text}' is neither true nor false")
        return unknown(condition.key, {condition.key})
    side = known('')
    if is_true or len(call) > 2:
        side = call[1] if is_true else call[2]
    sources = side.sources | condition.sources
    key = call.key([condition, side]) if sources else side.key
    return Value(side.text, key, sources)


def _find_exec(call: _Call) -> Value:
    if call.checking.scope.environment.get('PATH') is not None:
        return _unknown(call)
    return _pure(call)


def _param(call: _Call) -> Value:
    name = call[0].text
    scope = call.checking.scope
    is_open = scope.configurations.may_have_others()
    if name is None or is_open or scope.parameters & {name, ANY_VARIABLE}:
        return _unknown(call)
    if len(call) > 1:
        return call[1]
    call.error(
        f"no 'set_parameter' before this sets the parameter '{name}'",
        f'give a default: $(param {name} default)',
    )
    return _unknown(call)


def _for_variable(call: _Call) -> Value:
    name = call[0].text
    variables = call.checking.scope.variables
    if name is None:
        return _unknown(call)
    if name in variables:
        return variables[name]
    if len(call) > 1:
        return call[1]
    if ANY_VARIABLE not in variables:
        call.error(
            f"no 'for_each' or 'for' around this has the variable '{name}'",
            did_you_mean(name, variables),
        )
    return _unknown(call)


def _place(call: _Call) -> Value:
    value = _pure(call)
    checking = call.checking
    if checking.portable and checking.included is not None:
        name = call.substitution.name
        other = checking.included
        if name == 'dirname':
            other = os.path.dirname(other)
        if other != value.text:
            call.warn(
                f"behind an 'include', ROS 2 before Lyrical takes $({name}) "
                'for that of the included file',
                f"set it before the 'include': let: {{name: here, value: "
                f'$({name})}}',
            )
    return value


#: Stands for all names, of variables or parameters, when they are not known.
ANY_VARIABLE = ''

_SPECIAL: Mapping[str, Callable[[_Call], Value]] = {
    'var': _var,
    'env': _env,
    'eval': _eval,
    'command': _unknown,
    'find-exec': _find_exec,
    'anon': _unknown,
    'log_dir': _unknown,
    'launch_log_dir': _unknown,
    'if': _if,
    'param': _param,
    'for-var': _for_variable,
    'index': _for_variable,
    'dirname': _place,
    'filename': _place,
}
