import numpy as np
import pytest

from mctrack_experiments.papers.silhouettes.carpark_truth import Operator
from mctrack_experiments.papers.silhouettes.table1 import reproduce_silhouettes
from mctrack_ros.interfaces import ClassCode
from mctrack_ros.simulation import CARPARK, CarParkScenario


@pytest.fixture(scope='module')
def figures(here):
    return reproduce_silhouettes(seeds=(1,), duration_s=40)


def test_rates_follow_from_counts(figures):
    values = figures.figures
    assert values['events.perfect'] > 0
    assert values['events.correct'] == values['events.perfect'] / values['events.all']
    assert values['events.low'] <= values['events.correct'] <= values['events.high']
    assert values['events.all'] == values['pedestrians.events'] + values['vehicles.events']
    lost = values['pedestrians.judged'] - values['pedestrians.perfect']
    assert lost == values['pedestrians.lost']


def test_protocol_states_events_tables_and_seeds(figures):
    assert 'tuned on 1 to 3' in figures.protocol['seeds']
    for tracker in ('here', 'as printed'):
        assert f'{tracker}, pedestrians: true number down, tracked number across' in (
            figures.protocol
        )


def test_the_papers_own_parameters_stand_beside_on_the_same_recordings(figures):
    values = figures.figures
    assert {name.removeprefix('printed.') for name in values if name.startswith('printed.')} == {
        name for name in values if not name.startswith('printed.')
    }
    assert values['printed.events.correct'] < values['events.correct']


def test_an_operator_sees_parties_and_moves_of_cars():
    world = CARPARK.world(CarParkScenario(duration_s=30))
    renderer, operator = CARPARK.renderer(world, 0), Operator(world)
    for step in range(world.scenario.steps):
        operator.watch(step, renderer.frame(step)[1])
    people, _ = operator.perceived(ClassCode.PERSON)
    assert set(people.key.tolist()) <= set(world.party.tolist())
    assert np.bincount(people.key).max() > 20
    assert len(np.unique(np.column_stack([people.step, people.key]), axis=0)) == len(people.key)
    cars, _ = operator.perceived(ClassCode.VEHICLE)
    assert not (np.isin(cars.key // 1000, np.flatnonzero(world.parked.all(axis=0)))).any()
