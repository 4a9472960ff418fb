"""Parameters that may be set at run time: nothing keeps the values before."""

import json
from dataclasses import replace
from functools import reduce

import numpy as np
import pytest

from fusion_scenes import tick
from mctrack_ros.cli.sites import named_site
from mctrack_ros.config import (
    attributes_of,
    config_from,
    nested,
    parameters_of,
    replace_parameters,
)
from mctrack_ros.fusion import FUSION, open_fusion
from mctrack_ros.fusion.trackers import TRACKERS
from mctrack_ros.perception import trackers as cameras
from mctrack_ros.replay.proof.state import take_state

CAMERAS = ('cam1', 'cam2')


def other(parameter):
    """Return another value than the default one."""
    if parameter.kind is bool:
        return not parameter.default
    value = parameter.default * 1.5 + 1
    return type(parameter.default)(min(value, parameter.maximum or value))


def changeable(kind, methods, tag):
    for method in methods:
        for one in parameters_of(kind, given={tag: method}):
            if one.at_run_time:
                yield pytest.param(method, one, id=f'{method}-{one.name}')


@pytest.fixture(scope='module')
def views():
    site = named_site('pitch5')
    seen = replace(site, cameras={name: site.cameras[name] for name in CAMERAS}).views()
    return lambda: seen


@pytest.fixture(scope='module')
def opened(views):
    """Return a function that opens a tracker; those as they come only once."""
    return lambda config: open_fusion(config, CAMERAS, 1, views)


def configured(tracker, **values):
    return config_from(FUSION, nested({'tracker': tracker} | values))


def stale(value, sections, seen):
    """Yield where an object still holds one of some sections of a configuration."""
    seen.add(id(value))
    for name, each in attributes_of(value):
        if id(each) in sections:
            yield name
        elif type(each).__module__.startswith('mctrack_ros.') and id(each) not in seen:
            yield from stale(each, sections, seen)


def sections(config):
    yield id(config)
    for _, each in attributes_of(config):
        if type(each).__module__.endswith('.config'):
            yield from sections(each)


@pytest.mark.parametrize(('tracker', 'parameter'), changeable(FUSION, TRACKERS, 'tracker'))
def test_nothing_in_a_tracker_depends_on_what_such_a_parameter_was_before(
    tracker, parameter, opened
):
    before = configured(tracker)
    after = configured(tracker, **{parameter.name: other(parameter)})
    changed = opened(before)
    as_it_came = take_state(changed)
    replace_parameters(changed, before, after)
    gone = set(sections(before)) - set(sections(after))
    assert not list(stale(changed, gone, set()))
    fresh = take_state(opened(after))
    assert json.dumps(fresh.content) == json.dumps(as_it_came.content)
    for one, another in zip(fresh.arrays, as_it_came.arrays, strict=True):
        assert one.tobytes() == another.tobytes()


def test_a_tracker_goes_on_with_another_threshold():
    before = configured('joint')
    after = configured('joint', **{'management.most_tracks': 1})
    changed, kept = (open_fusion(before, CAMERAS) for _ in range(2))
    for index in range(60):
        if index == 30:
            replace_parameters(changed, before, after)
        people = [[0.0, 0.0], [10.0, 0.0]][: 1 + (index >= 30)]
        seen = tick(index, {name: np.array(people) for name in CAMERAS})
        shown = [each.step(seen).tracks.track_id.tolist() for each in (changed, kept)]
    assert shown == [[1], [1, 2]]


@pytest.mark.parametrize(
    ('method', 'parameter'), changeable(cameras.CAMERA, cameras.TRACKERS, 'local_tracker')
)
def test_nothing_in_a_camera_depends_on_what_such_a_parameter_was_before(method, parameter):
    area = {'grid.area': '0,0,10,10'} if method == 'likelihood_grid' else {}
    given = {'local_tracker': method} | area
    before, after = (
        config_from(cameras.CAMERA, nested(given | values))
        for values in ({}, {parameter.name: other(parameter)})
    )
    settings = replace(named_site('pitch5').cameras['cam1'], pipeline=before)
    changed = settings.open('cam1')
    replace_parameters(changed, before, after)
    assert value_of(before, parameter.name) != value_of(after, parameter.name)
    owner = parameter.name.rpartition('.')[0]
    gone = {id(value_of(before, owner))}
    assert gone.isdisjoint({id(value_of(after, owner))})
    assert not list(stale(changed, gone, set()))


def value_of(config, name):
    """Return what a dotted name stands for."""
    return reduce(getattr, name.split('.') if name else (), config)
