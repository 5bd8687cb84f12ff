# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What packages get of actions in YAML and XML files, without `launch`."""

from types import SimpleNamespace
from typing import Any

from colcon_yamllaunch.python_launch.worker import extensions
import pytest

ITEMS = 'list of entities'


@pytest.fixture(autouse=True)
def _types(monkeypatch: pytest.MonkeyPatch) -> None:
    """Play the modules that know types."""

    def typed(value: str, data_type: Any, *, can_be_str: bool) -> object:
        assert can_be_str
        return data_type(value)

    played = {
        'launch.frontend.type_utils': SimpleNamespace(
            check_is_list_entity=lambda t: t == ITEMS
        ),
        'launch.utilities.type_utils': SimpleNamespace(
            is_instance_of=lambda v, t, can_be_str: (
                isinstance(v, t) or (can_be_str and isinstance(v, str))
            ),
            get_typed_value=typed,
        ),
    }
    monkeypatch.setattr(
        extensions.importlib, 'import_module', played.__getitem__
    )


def written(
    children: list[Any] | None = None, kind: str = 'own', **attributes: Any
) -> dict[str, Any]:
    return {
        'type': kind,
        'attributes': attributes,
        'texts': {},
        'children': children,
        'position': ['/x', 2, 3],
    }


def yaml(**fields: Any) -> Any:
    return extensions._YamlEntity(written(**fields))


def xml(**fields: Any) -> Any:
    return extensions._XmlEntity(written(**fields))


@pytest.mark.parametrize('make', [yaml, xml])
def test_what_is_not_there_is_an_attribute_error(make: Any) -> None:
    made = make(nam='x')
    with pytest.raises(AttributeError, match="'name'; is 'nam' meant") as e:
        made.get_attr('name')
    assert e.value.position == ['/x', 2, 3]
    assert e.value.length == len('own')
    with pytest.raises(AttributeError):
        made.get_attr('item', data_type=ITEMS)
    assert made.get_attr('item', data_type=ITEMS, optional=True) is None


@pytest.mark.parametrize('make', [yaml, xml])
def test_what_is_not_asked_for_is_a_value_error(make: Any) -> None:
    made = make(wrld='x')
    made.get_attr('world', optional=True)
    with pytest.raises(ValueError, match="'wrld'; did you mean 'world'"):
        made.assert_entity_completely_parsed()


@pytest.mark.parametrize('make', [yaml, xml])
def test_children_that_are_not_asked_for_are_a_value_error(make: Any) -> None:
    made = make(children=[written()])
    with pytest.raises(ValueError, match='own'):
        made.assert_entity_completely_parsed()
    assert len(made.children) == 1
    made.assert_entity_completely_parsed()


def test_value_of_another_type_is_a_type_error() -> None:
    with pytest.raises(TypeError, match='a whole number, not a list'):
        yaml(a=[1]).get_attr('a', data_type=int)
    with pytest.raises(TypeError, match="a whole number, and 'x' is none"):
        xml(a='x').get_attr('a', data_type=int)
    with pytest.raises(TypeError, match='a list of mappings'):
        yaml(a=['x']).get_attr('a', data_type=ITEMS)
