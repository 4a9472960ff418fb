from dataclasses import dataclass

import pytest

from mctrack_ros.config import (
    ConfigError,
    config_from,
    nested,
    parameter,
    parameters_of,
    values_of,
)


@dataclass(frozen=True)
class Inner:
    gate: float = parameter(9.2, 'gate [m²]', minimum=0.0)
    method: str = parameter('gnn', 'method', choices=('gnn', 'nearest'))


@dataclass(frozen=True)
class Outer:
    count: int = parameter(3, 'how many', minimum=1, maximum=5)
    enabled: bool = parameter(True, 'whether')
    names: tuple[str, ...] = parameter(('one',), 'names')
    inner: Inner = Inner()


def test_what_is_not_given_keeps_its_default():
    config = config_from(Outer, {'inner': {'gate': 4.0}})
    assert config == Outer(inner=Inner(gate=4.0))


def test_a_list_of_strings_becomes_a_tuple():
    assert config_from(Outer, {'names': ['two', 'three']}).names == ('two', 'three')


def test_a_whole_number_serves_as_a_number():
    gate = config_from(Outer, {'inner': {'gate': 4}}).inner.gate
    assert gate == 4.0
    assert isinstance(gate, float)


@pytest.mark.parametrize(
    ('values', 'reason'),
    [
        ({'inner': {'gatte': 1.0}}, 'unknown key inner.gatte, expected one of'),
        ({'count': 'three'}, "count is 'three', expected a whole number"),
        ({'count': True}, 'count is True, expected a whole number'),
        ({'count': 1.5}, 'count is 1.5, expected a whole number'),
        ({'count': 9}, 'count is 9, expected 1 to 5'),
        ({'inner': {'gate': -1.0}}, 'inner.gate is -1.0, expected at least 0.0'),
        ({'inner': {'gate': float('nan')}}, 'inner.gate is nan, expected a finite number'),
        ({'inner': {'method': 'best'}}, r"inner.method is 'best', expected one of \['gnn'"),
        ({'inner': 3}, 'inner is 3, expected a mapping'),
        ({'enabled': 1}, 'enabled is 1, expected true or false'),
        ({'names': 'two'}, "names is 'two', expected a list of strings"),
        ({'names': ['two', 2]}, 'expected a list of strings'),
        ([1], r'the file is \[1\], expected a mapping'),
    ],
)
def test_wrong_values_are_refused_by_their_dotted_name(values, reason):
    with pytest.raises(ConfigError, match=reason):
        config_from(Outer, values)


def test_parameters_have_dotted_names_and_lead_back_to_the_configuration():
    flat = {p.name: p.default for p in parameters_of(Outer)}
    assert list(flat) == ['count', 'enabled', 'names', 'inner.gate', 'inner.method']
    assert config_from(Outer, nested(flat)) == Outer()
    assert values_of(Outer()) == nested(flat)
