from dataclasses import dataclass

import pytest

from mctrack_ros.config import (
    ConfigError,
    OneOf,
    config_from,
    misplaced,
    nested,
    of_chosen,
    parameter,
    parameters_of,
    tag,
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


@dataclass(frozen=True)
class Steady:
    model: str = tag('steady', 'still')
    noise: float = parameter(1.0, 'noise', minimum=0.0)


@dataclass(frozen=True)
class Winding:
    model: str = tag('winding')
    turn: float = parameter(0.5, 'turn', minimum=0.0)
    inner: Inner = Inner()


MODELS = {'steady': Steady, 'winding': Winding, 'still': Steady}
MODEL = OneOf('model', 'steady', 'how it moves', MODELS)


@dataclass(frozen=True)
class Site:
    motion: Steady | Winding = MODEL.field()
    count: int = parameter(3, 'how many', minimum=1, maximum=5)


@pytest.mark.parametrize('model', MODELS)
def test_the_parameters_of_the_named_method_lead_back_to_its_configuration(model):
    config = config_from(Site, {'motion': {'model': model}})
    assert config.motion == MODEL.made(model)
    flat = {p.name: p.default for p in parameters_of(Site, given={'motion.model': model})}
    flat['motion.model'] = model
    assert values_of(config) == nested(flat)
    assert config_from(Site, values_of(config)) == config


def test_only_the_named_method_has_its_parameters():
    names = [p.name for p in parameters_of(Site)]
    assert names == ['motion.model', 'motion.noise', 'count']
    names = [p.name for p in parameters_of(Site, given={'motion.model': 'winding'})]
    assert names == [
        'motion.model', 'motion.turn', 'motion.inner.gate', 'motion.inner.method', 'count',
    ]  # fmt: skip
    choice = next(parameters_of(Site))
    assert (choice.is_tag, choice.choices) == (True, ('steady', 'winding', 'still'))


def test_a_choice_is_read_by_itself_too():
    assert config_from(MODEL, {'noise': 2.0}) == Steady(noise=2.0)
    assert config_from(MODEL, {'model': 'winding', 'turn': 1}) == Winding(turn=1.0)


@pytest.mark.parametrize(
    ('motion', 'reason'),
    [
        ({'turn': 1.0}, 'motion.turn belongs to model winding, but motion.model is steady'),
        (
            {'model': 'winding', 'noise': 1.0},
            'motion.noise belongs to model steady or still, but motion.model is winding',
        ),
        ({'model': 'still', 'inner': {'gate': 1.0}}, 'motion.inner belongs to model winding'),
        ({'model': 'dancing'}, r"motion.model is 'dancing', expected one of \['steady', 'win"),
        ({'tern': 1.0}, r"unknown key motion.tern, expected one of \['model', 'noise'\]"),
        ({'model': 'winding', 'turn': -1.0}, 'motion.turn is -1.0, expected at least 0.0'),
    ],
)
def test_what_another_method_has_is_refused_by_its_name(motion, reason):
    with pytest.raises(ConfigError, match=reason):
        config_from(Site, {'motion': motion})


def test_of_a_recording_that_holds_all_methods_the_chosen_one_is_read():
    values = {'motion': {'model': 'winding', 'noise': 2.0, 'turn': 1.0}, 'count': 2}
    kept = of_chosen(Site, values)
    assert kept == {'motion': {'model': 'winding', 'turn': 1.0}, 'count': 2}
    assert of_chosen(Site, {'motion': {'tern': 1.0}}) == {'motion': {'tern': 1.0}}


def test_a_flat_name_far_down_says_whose_it_is_too():
    given = {'motion.inner.gate': 1.0}
    assert misplaced(Site, 'motion.inner.gate', '', given) == (
        'motion.inner.gate belongs to model winding, but motion.model is steady'
    )
    assert misplaced(Site, 'motion.tern', '', given) == ''
    assert misplaced(Site, 'count', '', given) == ''


def test_a_method_that_joins_later_can_be_chosen(monkeypatch):
    @dataclass(frozen=True)
    class Idle:
        model: str = tag('idle')

    monkeypatch.setitem(MODELS, 'idle', Idle)
    assert config_from(Site, {'motion': {'model': 'idle'}}).motion == Idle()
