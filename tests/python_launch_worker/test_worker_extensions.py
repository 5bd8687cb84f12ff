# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Actions and substitutions of packages, with ROS 2's own `launch`."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from support.ros_setup import RosSetup
from support.talking_worker import in_short, Message, TalkingWorker

# one worker is enough
pytestmark = pytest.mark.xdist_group('extensions')

MODULE = """\
import pathlib
import tempfile
from typing import List

from launch import Action
from launch.actions import ExecuteProcess
from launch.actions import SetLaunchConfiguration
from launch.frontend import Entity
from launch.frontend import expose_action
from launch.frontend import expose_substitution
from launch.substitution import Substitution
from launch.utilities import normalize_to_list_of_substitutions
from launch.utilities import perform_substitutions


@expose_action('labelled')
class Labelled(Action):
    def __init__(self, label, actions, count, pairs, **kwargs):
        super().__init__(**kwargs)
        self.label = label
        self.count = count
        self.pairs = pairs
        self.actions = actions

    @classmethod
    def parse(cls, entity, parser):
        _, kwargs = super().parse(entity, parser)
        assert isinstance(entity, Entity)
        kwargs['label'] = parser.parse_substitution(entity.get_attr('label'))
        kwargs['count'] = entity.get_attr(
            'count', data_type=int, optional=True, can_be_str=False
        )
        kwargs['pairs'] = []
        for pair in entity.get_attr(
            'pair', data_type=List[Entity], optional=True
        ) or ():
            value = parser.parse_substitution(pair.get_attr('value'))
            kwargs['pairs'].append((pair.get_attr('name'), value))
            pair.assert_entity_completely_parsed()
        children = entity.get_attr(
            'inside', data_type=List[Entity], optional=True
        )
        children = entity.children if children is None else []
        kwargs['actions'] = [
            parser.parse_action(child)
            for child in children
            if child.type_name != 'pair'
        ]
        return cls, kwargs

    def execute(self, context):
        label = perform_substitutions(context, self.label)
        if label == 'boom':
            raise RuntimeError('boom it is')
        if label == 'loop':
            context.asyncio_loop.create_task(None)
        return [
            *(SetLaunchConfiguration(n, v) for n, v in self.pairs),
            ExecuteProcess(cmd=['echo', label, str(self.count)]),
            *self.actions,
        ]


@expose_substitution('rendered')
class Rendered(Substitution):
    def __init__(self, texts):
        super().__init__()
        self.texts = [normalize_to_list_of_substitutions(t) for t in texts]

    @classmethod
    def parse(cls, data):
        return cls, {'texts': data}

    def perform(self, context):
        texts = [perform_substitutions(context, t) for t in self.texts]
        with tempfile.NamedTemporaryFile('w', delete=False) as file:
            file.write('|'.join(texts))
        self.path = pathlib.Path(file.name)
        return file.name

    def __del__(self):
        self.path.unlink()
"""
ENTRY = '[launch.frontend.launch_extension]\n{name} = {name}\n'


@pytest.fixture(scope='module')
def worker(
    ros_setup: RosSetup, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[TalkingWorker]:
    folder = tmp_path_factory.mktemp('site')
    for name, text in (('own', MODULE), ('broken', 'import nowhere_at_all\n')):
        (folder / f'{name}.py').write_text(text)
        metadata = folder / f'{name}-1.0.dist-info'
        metadata.mkdir()
        (metadata / 'METADATA').write_text(f'Name: {name}\nVersion: 1.0\n')
        entry = ENTRY.format(name=name)
        (metadata / 'entry_points.txt').write_text(entry)
    variables = dict(ros_setup.environment)
    before = variables.get('PYTHONPATH', '')
    variables['PYTHONPATH'] = f'{folder}:{before}'
    running = TalkingWorker(ros_setup.python, variables)
    running.begin()
    yield running
    running.close()


def entity(
    kind: str,
    children: list[dict[str, Any]] | None = None,
    line: int = 1,
    **attributes: Any,
) -> dict[str, Any]:
    texts = {n: str(v) for n, v in attributes.items() if isinstance(v, int)}
    return {
        'type': kind,
        'attributes': attributes,
        'texts': texts,
        'children': children,
        'position': ['/x.yaml', line, 3],
    }


def act(
    worker: TalkingWorker, written: dict[str, Any], frontend: str = 'yaml'
) -> list[Message]:
    return worker.ask_to_end(
        'action',
        entity=written,
        position=written['position'],
        file='/folder/x.yaml',
        frontend=frontend,
        scope={'configurations': {'who': 'me'}},
    )


def test_action_starts_what_it_says_in_its_scope(
    worker: TalkingWorker,
) -> None:
    child = entity('executable', line=5, cmd='echo $(var a) $(dirname)')
    told = act(
        worker,
        entity(
            'labelled',
            [child, entity('group', [child])],
            label='$(var who)',
            count=3,
            pair=[entity('pair', name='a', value='b')],
        ),
    )
    started = [m for m in told if m['say'] == 'process']
    assert [m['argv'] for m in started] == [
        ['echo', 'me', '3'],
        ['echo', 'b', '/folder'],
        ['echo', 'b', '/folder'],
    ]
    # what stands in YAML shows its output
    assert [m['output'] for m in started] == ['log', 'both', 'both']
    # the module of the package is installed, and none of the user's files
    assert [m['position'][1] for m in started[1:]] == [5, 5]
    assert told[-1]['scope']['configurations'] == {'who': 'me', 'a': 'b'}


def test_xml_gives_texts_and_elements(worker: TalkingWorker) -> None:
    told = act(
        worker,
        entity(
            'labelled',
            [
                entity('pair', [], name='a', value='b'),
                entity('executable', [], cmd='echo $(var a)'),
            ],
            label='x',
            count='3',
        ),
        'xml',
    )
    assert in_short(told) == ['start echo', 'start echo']
    (first, second) = [m['argv'] for m in told if m['say'] == 'process']
    assert (first, second) == (['echo', 'x', '3'], ['echo', 'b'])


@pytest.mark.parametrize(
    ('written', 'text', 'line'),
    [
        (
            entity('labelled', [], lable='x'),
            "'labelled' needs the attribute 'label'; is 'lable' meant for it?",
            1,
        ),
        (
            entity('labelled', [], label='x', countt=1),
            "'labelled' has no attribute 'countt'; did you mean 'count'?",
            1,
        ),
        (
            entity('labelled', [], label='x', count='3'),
            "'count' of 'labelled' wants a whole number, not a text",
            1,
        ),
        (
            entity('labelled', [entity('nobody', line=4)], label='x'),
            "no package here has the action 'nobody'; the launch extension "
            "'broken' cannot be imported: ModuleNotFoundError: No module "
            "named 'nowhere_at_all'",
            None,
        ),
        (
            entity(
                'labelled',
                [entity('executable', line=4, cmd=['x'])],
                label='x',
            ),
            "'cmd' of 'executable' wants a text, not a list",
            4,
        ),
        (
            entity('labelled', label='x'),
            "'labelled' needs actions inside: a list, or 'children' with one",
            1,
        ),
        (
            entity('labelled', [], label='$(nobody x)'),
            'RuntimeError: Unknown substitution: nobody',
            None,
        ),
        (entity('labelled', [], label='boom'), 'RuntimeError: boom it is', 1),
    ],
)
def test_mistakes_name_their_place(
    worker: TalkingWorker, written: dict[str, Any], text: str, line: int | None
) -> None:
    error = act(worker, written)[-1]['error']
    assert error['text'] == text
    places = [frame['position'] for frame in error['frames']]
    assert places[0][0] == '/x.yaml' or line is None
    if line is not None:
        assert places[0][1] == line


def test_what_needs_the_loop_is_refused(worker: TalkingWorker) -> None:
    told = act(worker, entity('labelled', [], label='loop'))
    assert 'event loop' in told[-1]['refused']


def test_file_of_a_substitution_stays(worker: TalkingWorker) -> None:
    told = worker.ask(
        'substitute',
        name='rendered',
        arguments=['a b', ''],
        position=['/x.yaml', 2, 5],
        file='/folder/x.yaml',
        scope={},
    )
    (value,) = [m['text'] for m in told if m['say'] == 'value']
    worker.begin()
    path = Path(value)
    assert path.read_text() == 'a b|'
    path.unlink()


def test_extension_that_cannot_be_imported_is_told_once(
    worker: TalkingWorker,
) -> None:
    act(worker, entity('labelled', [], label='x'))
    told = act(worker, entity('labelled', [], label='x'))
    assert [m for m in told if m['say'] == 'warning'] == []
