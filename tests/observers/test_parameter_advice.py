# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A node that refuses the type of a parameter, and where it was set."""

from colcon_yamllaunch.observers.failure_advice import parameter_advice
from colcon_yamllaunch.plan.plan import SetParameter
from colcon_yamllaunch.plan.position import Position
import pytest

RCLPY = (
    'rclpy.exceptions.InvalidParameterTypeException: Trying to set parameter '
    "'rate' to '1' of type '{}', expecting type '{}': rate"
)
RCLCPP = (
    "  what():  parameter 'rate' has invalid type: expected [{1}] got [{0}]"
)
NOT_ALLOWED = (
    "[ERROR] [x]: parameter 'rate' has invalid type: Wrong parameter type, "
    'parameter {{rate}} is of type {{{1}}}, setting it to {{{0}}} is not '
    'allowed.'
)


def rate(value, line=7, origins=()):
    return SetParameter(
        'rate', value, Position('/ws/a.yaml', line, 9), origins
    )


@pytest.mark.parametrize('text', [RCLPY, RCLCPP, NOT_ALLOWED])
def test_error_of_each_client_library_is_understood(text):
    names = ('INTEGER', 'DOUBLE') if text is RCLPY else ('integer', 'double')
    assert parameter_advice(text.format(*names), [rate('1')]) == (
        "the node takes a double for 'rate': give it 1.0 instead of 1, at "
        '/ws/a.yaml:7:9'
    )


@pytest.mark.parametrize(
    ('value', 'got', 'wanted', 'cure'),
    [
        ('"fast"', 'string', 'double', 'a double'),
        ('[0, 10]', 'integer_array', 'double_array', '[0.0, 10.0]'),
        ('[1.5, 2]', 'string', 'double_array', '[1.5, 2.0]'),
        ('["a", 1]', 'string_array', 'double_array', 'a list of doubles'),
        ('1', 'integer', 'double_array', '[1.0]'),
        ('[1]', 'integer_array', 'integer', 'an integer'),
        ('10.0', 'double', 'integer', '10'),
        ('10.5', 'double', 'integer', 'an integer'),
        ('"10"', 'string', 'integer', '10'),
        ('"True"', 'string', 'bool', 'true'),
        ('0', 'integer', 'bool', 'false'),
        ('2', 'integer', 'bool', 'a bool'),
        ('7', 'integer', 'string', "'7'"),
        ('true', 'bool', 'integer', 'an integer'),
    ],
)
def test_advice_has_a_value_of_the_wanted_type(value, got, wanted, cure):
    line = RCLCPP.format(got, wanted)
    text = parameter_advice(line, [rate(value)])
    assert f': give it {cure} instead of {value}, at ' in text


def test_last_parameter_of_the_type_is_named():
    given = [rate('1', 1), rate('2', 2), rate('0.5', 3)]
    text = parameter_advice(RCLCPP.format('integer', 'double'), given)
    assert text.endswith('instead of 2, at /ws/a.yaml:2:9')


def test_advice_names_the_origin_of_the_value():
    origin = Position('/ws/top.yaml', 3, 5)
    given = [rate('1', origins=(origin,))]
    text = parameter_advice(RCLCPP.format('integer', 'double'), given)
    assert text.endswith(' at /ws/a.yaml:7:9, passed by /ws/top.yaml:3:5')


def test_advice_names_the_source_of_an_installed_file(tmp_path):
    (tmp_path / 'source.yaml').write_text('')
    (tmp_path / 'installed.yaml').symlink_to('source.yaml')
    place = Position(f'{tmp_path}/installed.yaml', 4, 5)
    given = [SetParameter('rate', '1', place)]
    text = parameter_advice(RCLCPP.format('integer', 'double'), given)
    assert text.endswith('/source.yaml:4:5')


def test_parameter_without_value_has_no_position():
    text = parameter_advice(RCLPY.format('INTEGER', 'STRING'), [])
    assert text == (
        "the node takes a string for 'rate', and it was given an integer"
    )


def test_other_lines_have_no_advice():
    assert parameter_advice('parameter rate is fine', [rate('1')]) is None
