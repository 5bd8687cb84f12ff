# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Actions and substitutions as packages beside ROS 2's own bring them."""

from launch.action import Action
from launch.actions import ExecuteProcess, LogInfo
from launch.condition import Condition
from launch.frontend import expose_action, expose_substitution
from launch.substitution import Substitution
from launch.utilities import (
    normalize_to_list_of_substitutions,
    perform_substitutions,
)
from launch_ros.actions import Node


class IsLong(Condition):
    """Holds for texts of more than three characters."""

    def __init__(self, text):
        self._text = normalize_to_list_of_substitutions(text)
        super().__init__(predicate=self._is_long)

    def _is_long(self, context):
        return len(perform_substitutions(context, self._text)) > 3


@expose_substitution('shout')
class Shout(Substitution):
    """A text in capitals."""

    def __init__(self, text):
        super().__init__()
        self._text = normalize_to_list_of_substitutions(text)

    @classmethod
    def parse(cls, data):
        return cls, {'text': data[0]}

    def describe(self):
        return 'Shout()'

    def perform(self, context):
        return perform_substitutions(context, self._text).upper()


@expose_action('camera_pair')
class CameraPair(Action):
    """
    Two cameras, left and right.

    :param rate: Images a second
    """

    def __init__(self, *, rate='10', **kwargs):
        super().__init__(**kwargs)
        self._rate = normalize_to_list_of_substitutions(rate)

    @classmethod
    def parse(cls, entity, parser):
        _, kwargs = super().parse(entity, parser)
        rate = entity.get_attr('rate', optional=True)
        if rate is not None:
            kwargs['rate'] = parser.parse_substitution(rate)
        return cls, kwargs

    def execute(self, context):
        rate = perform_substitutions(context, self._rate)
        context.launch_configurations['pair_rate'] = rate
        return [
            LogInfo(msg=f'note: a pair at {rate} Hz'),
            *(
                Node(
                    package='robot_parts',
                    executable='part',
                    name=f'{side}_camera',
                    parameters=[{'rate': int(rate)}],
                )
                for side in ('left', 'right')
            ),
        ]


class Guarded(ExecuteProcess):
    """A process whose class is one of somebody else."""

    def __init__(self, *, word, **kwargs):
        super().__init__(cmd=['part', 'guarded', word], **kwargs)

    def execute(self, context):
        context.environment['T_GUARDED'] = 'yes'
        return super().execute(context)
