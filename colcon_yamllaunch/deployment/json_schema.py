# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The JSON Schema of deployment files, from the tables of their keys.

A key without a schema here is an error, so none is forgotten. Ranges and
choices are those that the readers of the keys use. The draft is that of
`language.vocabulary.json_schema`.
"""

from collections.abc import Mapping, Sequence
import json
from typing import get_args

from colcon_yamllaunch.deployment.deployment import OnLost, Sync
from colcon_yamllaunch.deployment.deployment_file import (
    FILE_KEYS,
    LAYER_KEYS,
    MATCH_KEYS,
)
from colcon_yamllaunch.deployment.machine_settings import (
    KINDS,
    LOST_AFTER,
    MACHINE_SETTINGS,
    NAME,
)
from colcon_yamllaunch.deployment.process_settings import (
    CONDITIONS,
    MAXIMUM_CPUS,
    RESTART_KEYS,
    SETTINGS,
    SIZE,
    STATES,
)
from colcon_yamllaunch.deployment.values import VARIABLE, YEAR
from colcon_yamllaunch.plan.member_settings import (
    BEYOND_LIMIT,
    ON_TIMEOUT,
    READY_TIMEOUT,
    RESTART_WHEN,
)
from colcon_yamllaunch.plan.plan import OUTPUT_MODES

Schema = dict[str, object]

#: The draft of JSON Schema that the schema is written in.
DRAFT = 'http://json-schema.org/draft-07/schema#'

# any scalar is a text, as in 7447
_TEXT: Schema = {'type': ['string', 'number', 'boolean'], 'minLength': 1}
_FLAG: Schema = {'type': 'boolean'}
_CPU_NUMBERS = r'[0-9]+(-[0-9]+)?(, *[0-9]+(-[0-9]+)?)*'


def schema_text() -> str:
    """Return the JSON Schema as text, one line end at its end."""
    return json.dumps(json_schema(), indent=2, ensure_ascii=False) + '\n'


def json_schema() -> Schema:
    """
    Return the JSON Schema of deployment files.

    It cannot say whether a machine or process exists.
    """
    file = {
        'include': _described(
            'A deployment file that this one changes.', _TEXT
        ),
        'profiles': _mapping_of(
            _object(_keys(_LAYER, LAYER_KEYS)),
            'What --profile NAME adds to the file.',
        ),
        **_LAYER,
    }
    return {
        '$schema': DRAFT,
        'title': 'Deployment file',
        'description': 'What colcon launch --deploy reads.',
        **_object(_keys(file, FILE_KEYS), minProperties=1),
        'definitions': {
            'machine': {'anyOf': [_TEXT, _machine()]},
            'rule': _rule(),
            'condition': _condition(),
        },
    }


def _described(text: str, schema: Schema) -> Schema:
    return {'description': text, **schema}


def _keys(
    schemas: Mapping[str, Schema], keys: Sequence[str]
) -> Mapping[str, Schema]:
    """Return the schemas of keys; one that has none is an error."""
    return {key: schemas[key] for key in keys}


def _object(properties: Mapping[str, Schema], **more: object) -> Schema:
    return {
        'type': 'object',
        'additionalProperties': False,
        'properties': dict(properties),
        **more,
    }


def _mapping_of(values: Schema, description: str) -> Schema:
    return {
        'description': description,
        'type': 'object',
        'additionalProperties': values,
    }


def _list_of(items: Schema, count: int = 1) -> Schema:
    return {'type': 'array', 'minItems': count, 'items': items}


def _one_or_more(item: Schema) -> Schema:
    return {'anyOf': [item, _list_of(item)]}


def _times(count: int) -> Schema:
    return {**_list_of(_seconds(), count), 'maxItems': count}


def _choice(words: Sequence[str]) -> Schema:
    return {'enum': list(words)}


def _whole(lowest: int, highest: float | None = None) -> Schema:
    schema: Schema = {'type': 'integer', 'minimum': lowest}
    return schema if highest is None else {**schema, 'maximum': highest}


def _number(lowest: float, highest: float) -> Schema:
    return {'type': 'number', 'minimum': lowest, 'maximum': highest}


def _seconds() -> Schema:
    return _number(0, YEAR)


def _ref(name: str) -> Schema:
    return {'$ref': f'#/definitions/{name}'}


def _size() -> Schema:
    # JSON Schema has no flags
    pattern = SIZE.pattern.replace('[KMGT]', '[KMGTkmgt]')
    pattern = pattern.replace('i?B?', '[Ii]?[Bb]?')
    return {'anyOf': [_whole(1), {'type': 'string', 'pattern': _all(pattern)}]}


def _all(pattern: str) -> str:
    return f'^({pattern})$'


def _variables() -> Schema:
    return {
        'type': 'object',
        'propertyNames': {'pattern': _all(VARIABLE.pattern)},
        'additionalProperties': {'type': ['string', 'number', 'boolean']},
    }


def _machine() -> Schema:
    settings = _keys(_MACHINE, (*KINDS, *MACHINE_SETTINGS))
    return _object(settings, oneOf=[{'required': [kind]} for kind in KINDS])


def _rule() -> Schema:
    match: Schema = {
        'anyOf': [
            _TEXT,
            _object(dict.fromkeys(MATCH_KEYS, _TEXT), minProperties=1),
        ]
    }
    own = {
        'match': _described('What it is for.', match),
        'machine': _described('The machine that they run on, or here.', _TEXT),
    }
    return _object(
        {**own, **_keys(_SETTINGS, tuple(SETTINGS))},
        required=['match'],
        minProperties=2,
    )


def _condition() -> Schema:
    kinds: list[Schema] = [{'const': 'running'}]
    for kind in CONDITIONS:
        known: dict[str, Schema] = {kind: _CONDITION[kind]}
        if kind == 'topic':
            known['message'] = _FLAG
        kinds.append(_object(known, required=[kind]))
    return {'anyOf': kinds}


_FRAMES: Schema = {**_list_of(_TEXT, 2), 'maxItems': 2}
_CONDITION: Mapping[str, Schema] = {
    'topic': _described('It has a publisher of this topic.', _TEXT),
    'service': _described('This service has a server.', _TEXT),
    'action': _described('This action has a server.', _TEXT),
    'node': _described('This node is in the graph.', _TEXT),
    'lifecycle': _described(
        'Its lifecycle node is in this state.', _choice(STATES)
    ),
    'parameter': _object(
        {'name': _TEXT, 'equals': {'type': ['string', 'number', 'boolean']}},
        required=['name', 'equals'],
    ),
    'transform': _described('There is a transform between frames.', _FRAMES),
    'log': _described('A line of its output matches.', _TEXT),
    'port': _described(
        'Something listens on this TCP port.',
        {
            'anyOf': [
                _whole(1, 65535),
                {'type': 'string', 'pattern': '^(.*:)?[0-9]+$'},
            ]
        },
    ),
    'file': _described('This path exists.', _TEXT),
    'command': _described('This command exits with 0.', _TEXT),
    'after': _described('It has been running so long (seconds).', _seconds()),
}
_RESTART: Mapping[str, Schema] = {
    'when': _choice(RESTART_WHEN),
    'max': _described('How often at most.', _whole(0, 1000000)),
    'window': _described('Within how many seconds.', _seconds()),
    'delay': _described(
        'Seconds before a restart, or the first and the longest delay.',
        {'anyOf': [_seconds(), _times(2)]},
    ),
    'then': _described('What happens then.', _choice(BEYOND_LIMIT)),
    'with': _described('What is restarted with it.', _one_or_more(_TEXT)),
    'command': _described(
        'A command that must succeed before.',
        {'anyOf': [_TEXT, {'type': 'array', 'items': _TEXT}]},
    ),
}
_SETTINGS: Mapping[str, Schema] = {
    'ready': _described(
        'What holds once it is ready.', _one_or_more(_ref('condition'))
    ),
    'after': _described(
        'What must be ready before it starts; [] for nothing.',
        {'anyOf': [_TEXT, _list_of(_TEXT, 0)]},
    ),
    'ready_timeout': _described(
        'After how many seconds it is reported as not ready '
        f'({READY_TIMEOUT:g} by default).',
        _seconds(),
    ),
    'on_timeout': _described(
        'What follows for those that wait for it.', _choice(ON_TIMEOUT)
    ),
    'restart': _described(
        'When it is started again.',
        {
            'anyOf': [
                _choice(RESTART_WHEN),
                _object(_keys(_RESTART, RESTART_KEYS)),
            ]
        },
    ),
    'critical': _described('Whether its failure ends the launch.', _FLAG),
    'optional': _described('Whether its failure does not count.', _FLAG),
    'memory': _described('Memory that it may use.', _size()),
    'memory_high': _described('Memory from which on it is slower.', _size()),
    'cpu': _described(
        'Processor time, as 150% or 1.5.',
        {
            'anyOf': [
                _number(0.01, MAXIMUM_CPUS),
                {'type': 'string', 'pattern': r'^[0-9]+(\.[0-9]+)?%$'},
            ]
        },
    ),
    'cpus': _described(
        'The processors that it runs on.',
        _one_or_more(
            {
                'anyOf': [
                    _whole(0, MAXIMUM_CPUS - 1),
                    {'type': 'string', 'pattern': _all(_CPU_NUMBERS)},
                ]
            }
        ),
    ),
    'io': _described('Its weight for disks.', _whole(1, 10000)),
    'tasks': _described('Processes and threads.', _whole(1)),
    'nice': _described('Its nice value.', _whole(-20, 19)),
    'scheduling': _described(
        'Its scheduling policy.',
        _object(
            {
                'fifo': _whole(1, 99),
                'rr': _whole(1, 99),
                'deadline': _times(3),
            },
            minProperties=1,
            maxProperties=1,
        ),
    ),
    'oom': _described(
        'Whether it is killed first or last when memory runs out.',
        {'anyOf': [_choice(('first', 'last')), _whole(-1000, 1000)]},
    ),
    'env': _described('Its environment variables.', _variables()),
    'user': _described('The user that it runs as.', _TEXT),
    'directory': _described(
        'Its working directory.', {'type': 'string', 'pattern': '^(/|~$|~/)'}
    ),
    'output': _described('Where its output goes.', _choice(OUTPUT_MODES)),
}
_NAMES: Schema = {'type': 'string', 'pattern': _all(VARIABLE.pattern)}
_MACHINE: Mapping[str, Schema] = {
    'ssh': _described('The destination for ssh.', _TEXT),
    'slurm': _described(
        'Options of srun.',
        {'anyOf': [{'type': ['string', 'null']}, _list_of(_TEXT, 0)]},
    ),
    'connect': _described(
        'A command that runs another one there.', _one_or_more(_TEXT)
    ),
    'workspace': _described('The folder of the workspace there.', _TEXT),
    'sync': _described('How the code gets there.', _choice(get_args(Sync))),
    'on_lost': _described(
        'What happens when the connection is lost.', _choice(get_args(OnLost))
    ),
    'lost_after': _described(
        'After how many seconds of silence it is lost.', _number(*LOST_AFTER)
    ),
    'env': _described(
        'Variables that are sent, or set.',
        {
            'anyOf': [
                _NAMES,
                _list_of(_NAMES, 0),
                {
                    **_variables(),
                    'additionalProperties': {
                        'type': ['string', 'number', 'boolean', 'null']
                    },
                },
            ]
        },
    ),
    'setup': _described('A file there that is sourced first.', _TEXT),
    'python': _described('The Python there.', _TEXT),
}
_LAYER: Mapping[str, Schema] = {
    'machines': {
        **_mapping_of(_ref('machine'), 'The machines, by name.'),
        'propertyNames': {
            'pattern': _all(NAME.pattern),
            'not': {'const': 'here'},
        },
    },
    'defaults': _described(
        'What holds for all machines.',
        _object(_keys(_MACHINE, tuple(MACHINE_SETTINGS))),
    ),
    'processes': _described(
        'Rules; for each setting, the first one that matches decides.',
        _list_of(_ref('rule'), 0),
    ),
    'args': _mapping_of(
        {'type': ['string', 'number', 'boolean', 'null']},
        'Launch arguments, which the command line overrides.',
    ),
}
