# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What a node sees of its command line, so that two launchers compare.

Any number of parameter files and `-p` is one stream to a node: the last value
counts, for each pattern of node names. All else keeps its order.
"""

import json
from typing import Any

import yaml


def outcome(
    returncode: int, records: list[dict[str, Any]], signals: list[str]
) -> dict[str, Any]:
    """Return what a launch came to, in the form of the expected files."""
    return {
        'exit_ok': returncode == 0,
        'processes': sorted(map(as_seen, records), key=_order),
        'signals': signals,
    }


def _order(process: dict[str, Any]) -> str:
    return json.dumps(process, sort_keys=True)


def as_seen(record: dict[str, Any]) -> dict[str, Any]:
    """Return what a process that wrote down its start sees of it."""
    reader = _ArgumentReader(record['params'])
    reader.read(record['args'])
    same = {key: record[key] for key in ('exe', 'from', 'cwd', 'env')}
    return {
        **same,
        'args': reader.own,
        'ros': reader.ros,
        'node': reader.node,
        'namespace': reader.namespace,
        'params': reader.parameters,
    }


class _ArgumentReader:
    """Reads arguments as a node does."""

    def __init__(self, parameter_files: list[Any]) -> None:
        self._files = parameter_files
        self.own: list[str] = []
        self.ros: list[Any] = []
        self.node: str | None = None
        self.namespace: str | None = None
        self.parameters: dict[str, dict[str, Any]] = {}

    def read(self, arguments: list[str]) -> None:
        rest = iter(arguments)
        is_ros = False
        for argument in rest:
            if argument == '--ros-args':
                is_ros = True
            elif not is_ros:
                self.own.append(argument)
            elif argument == '--':
                is_ros = False
            elif argument == '--params-file':
                self._file(self._files[int(next(rest))])
            elif argument in ('-p', '--param'):
                self._parameter(next(rest))
            elif argument in ('-r', '--remap'):
                self._remap(next(rest))
            else:
                self.ros.append(argument)

    def _file(self, content: Any) -> None:
        if not isinstance(content, dict):
            self.ros.append(['params-file', content])
            return
        for pattern, body in content.items():
            if isinstance(body, dict) and 'ros__parameters' in body:
                parameters = self.parameters.setdefault(pattern, {})
                parameters.update(_flatten(body['ros__parameters']))
            else:
                self.ros.append(['params-file', {pattern: body}])

    def _parameter(self, rule: str) -> None:
        name, _, value = rule.partition(':=')
        parameters = self.parameters.setdefault('/**', {})
        parameters[name] = yaml.safe_load(value)

    def _remap(self, rule: str) -> None:
        name, _, value = rule.partition(':=')
        if name == '__node':
            self.node = value
        elif name == '__ns':
            self.namespace = value
        else:
            self.ros.append(['remap', rule])


def _flatten(values: dict[str, Any], prefix: str = '') -> dict[str, Any]:
    flat: dict[str, Any] = {}
    for name, value in values.items():
        if isinstance(value, dict) and value:
            flat.update(_flatten(value, f'{prefix}{name}.'))
        else:
            flat[f'{prefix}{name}'] = value
    return flat
