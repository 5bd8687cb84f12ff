# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The values of texts in YAML that no launch file is, in bounded time."""

from typing import Any

from colcon_yamllaunch.language.syntax.yaml_reader import MAXIMUM_DEPTH
import yaml

#: How many values a text may have once its aliases are expanded: whoever
#: shows or merges them expands them.
MAXIMUM_EXPANDED = 100_000

_Loader: Any = getattr(yaml, 'CSafeLoader', yaml.SafeLoader)


class UnusableYamlError(Exception):
    """A text is no YAML, or such that nobody can use it; says why."""


def load_yaml(text: str) -> Any:
    """
    Return what PyYAML makes of a text.

    :raises UnusableYamlError: when it is not YAML, or exceeds a limit
    """
    try:
        # without aliases a text has fewer values than characters
        if '*' in text and '&' in text:
            _refuse_large(text)
        return yaml.safe_load(text)
    except RecursionError as e:
        raise UnusableYamlError('it is nested too deep') from e
    except (yaml.YAMLError, ValueError, LookupError, OverflowError) as e:
        # a scalar with a tag that it does not fit fails in its own way
        raise UnusableYamlError(str(e).split('\n', 1)[0]) from e


def _refuse_large(text: str) -> None:
    """
    Count the values of a text with its aliases expanded.

    :raises UnusableYamlError: when there are too many
    """
    sizes: dict[str, int] = {}
    open_sizes: list[int] = [0]
    open_anchors: list[str | None] = []
    loader = _Loader(text)
    try:
        while not isinstance(event := loader.get_event(), yaml.StreamEndEvent):
            size = 0
            if isinstance(event, yaml.CollectionStartEvent):
                open_sizes.append(1)
                open_anchors.append(event.anchor)
            elif isinstance(event, yaml.CollectionEndEvent):
                size = open_sizes.pop()
                sizes[open_anchors.pop() or ''] = size
            elif isinstance(event, yaml.ScalarEvent):
                size = 1
                sizes[event.anchor or ''] = 1
            elif isinstance(event, yaml.AliasEvent):
                # within what it names, it is a circle, which shows as such
                size = sizes.get(event.anchor or '', 1)
            open_sizes[-1] += size
            if open_sizes[-1] > MAXIMUM_EXPANDED:
                raise UnusableYamlError(
                    f'it has more than {MAXIMUM_EXPANDED} values once its '
                    'aliases are expanded'
                )
            if len(open_anchors) > MAXIMUM_DEPTH:
                raise UnusableYamlError('it is nested too deep')
    finally:
        loader.dispose()
