"""Why a track is what it is: stored or found again, in words, numbers and an image."""

import dataclasses
import json

import cv2
import numpy as np
import pytest

from fusion_scenes import PERIOD_NS, detections
from mctrack_ros.config import ConfigError
from mctrack_ros.explain import (
    COLUMNS,
    candidate_rows,
    course,
    draw_explanation,
    history_of,
    sentences,
    write_history,
)
from mctrack_ros.explain.words import reason_of
from mctrack_ros.fusion import JointConfig
from mctrack_ros.interfaces import Candidates, Decisions, Reason
from mctrack_ros.recording import BagReader, BagWriter
from mctrack_ros.replay.track import track_bag
from mctrack_ros.site.camera import CameraSettings
from mctrack_ros.site.site import SiteConfig

CAMERAS = ('one', 'two')
SITE = SiteConfig('hall', 'map', 0.08, '', dict.fromkeys(CAMERAS, CameraSettings()), JointConfig())
TICKS = 80
LOST = range(50, 65)


def places(index):
    """Return two who meet in the middle; nobody sees the first for a while."""
    walk = 0.04 * index - 1.2
    people = [[walk, 0.3], [-walk, -0.3]]
    return people[1:] if index in LOST else people


@pytest.fixture(scope='module')
def bags(tmp_path_factory):
    """Return a folder with detections, and bags tracked from them with and without reasons."""
    folder = tmp_path_factory.mktemp('explain')
    rng = np.random.default_rng(3)
    with BagWriter(folder / 'detections') as bag:
        for index in range(TICKS):
            stamp_ns = 10**12 + index * PERIOD_NS + PERIOD_NS // 2
            for camera in CAMERAS:
                seen = np.array(places(index)) + rng.normal(0, 0.12, (len(places(index)), 2))
                bag.write_rows(f'/{camera}/detections', detections(stamp_ns, seen), 'map')
    for name, explain in (('plain', False), ('stored', True)):
        track_bag(folder / 'detections', folder / name, SITE, processes=1, explain=explain)
    return folder


def contents(bag, topics=None):
    with BagReader(bag) as reader:
        return list(reader.serialized(topics))


def test_storing_the_reasons_leaves_all_else_the_same_bytes(bags):
    stored = contents(bags / 'stored' / 'bag')
    rest = [each for each in stored if not each[0].startswith('/explanation/')]
    assert len(stored) == len(rest) + 2 * TICKS
    assert rest == contents(bags / 'plain' / 'bag')


@pytest.mark.parametrize('at', [0.0, 1.2, 3.16])
def test_what_is_stored_is_what_is_found_again(bags, at):
    stored = history_of(bags / 'stored' / 'bag', 1, at)
    found = [
        history_of(bags / 'plain' / 'bag', 1, at),
        history_of(bags / 'detections', 1, at, site=SITE),
    ]
    assert stored.is_stored
    for again in found:
        assert not again.is_stored
        assert again.is_same
        assert sentences(again) == sentences(stored)
        assert len(again.explanations) == len(stored.explanations)
        for one, other in zip(again.explanations, stored.explanations):
            for mine, theirs in (
                (one.candidates, other.candidates),
                (one.decisions, other.decisions),
            ):
                for name in mine.COLUMNS:
                    assert getattr(mine, name).tobytes() == getattr(theirs, name).tobytes()


def test_people_who_meet_are_weighed_against_each_other(bags):
    history = history_of(bags / 'plain' / 'bag', 1, 1.2)
    rows = [dict(zip(COLUMNS, row)) for row in candidate_rows(history)]
    assert {row['camera'] for row in rows} == set(CAMERAS)
    assert sum(row['what became of it'] == 'taken' for row in rows) == 2
    assert sum(row['what became of it'].startswith('track 2 takes it') for row in rows) == 2
    assert 'Near it: 2 at 0.' in ' '.join(sentences(history))


def test_who_is_lost_coasts_and_ends_or_goes_on(bags):
    history = history_of(bags / 'plain' / 'bag', 1, 2.2, 0.6)
    said = sentences(history)
    assert said[1] == 'It coasts: nothing has supported it for 0.24 s; it ends after 1.00 s.'
    assert 'one offers nothing inside the gate; its nearest detection is' in ' '.join(said)
    withheld, seen, *_ = course(history)
    assert withheld.endswith('it ends after 1.00 s. It is not published.')
    assert seen.endswith('track 1: It is seen by one and two.')
    said = ' '.join(sentences(history_of(bags / 'plain' / 'bag', 1, 2.28)))
    assert 'not published: cameras that should have seen it did not (log-odds of having' in said


def test_the_image_shows_the_moment(bags, tmp_path):
    for name, at in (('met', 1.2), ('lost', 2.2), ('first', 0.0)):
        draw_explanation(history_of(bags / 'plain' / 'bag', 1, at), tmp_path / f'{name}.png')
        image = cv2.imread(str(tmp_path / f'{name}.png'))
        assert image.shape[1] > 1000
        assert image.std() > 10


def test_the_numbers_are_json(bags, tmp_path):
    write_history(history_of(bags / 'plain' / 'bag', 1, 1.2, 0.2), tmp_path / 'why.json')
    content = json.loads((tmp_path / 'why.json').read_text())
    assert [round(tick['seconds'], 2) for tick in content['ticks']] == [
        *(1.2, 1.24, 1.28, 1.32, 1.36, 1.4)
    ]
    chosen = {row['choice'] for row in content['ticks'][0]['candidates']}
    assert chosen == {'TAKEN', 'PASSED_OVER'}


def test_errors_say_what_is_there(bags):
    bag = bags / 'plain' / 'bag'
    with pytest.raises(ValueError, match=r'no track 99 at 1\.2 s; there are: 1, 2$'):
        history_of(bag, 99, 1.2)
    for at in (-1.0, 77.0):
        with pytest.raises(ValueError, match=rf'no tick at {at:g} s: .* from 0 to 3\.16 s'):
            history_of(bag, 1, at)
    with pytest.raises(ConfigError, match='does not say how fusion was set: name the site'):
        history_of(bags / 'detections', 1, 1.2)


def test_a_replay_that_differs_from_the_recording_is_told(bags):
    motion = dataclasses.replace(SITE.fusion.motion, sensor_sigma=0.5)
    other = dataclasses.replace(SITE, fusion=dataclasses.replace(SITE.fusion, motion=motion))
    history = history_of(bags / 'plain' / 'bag', 1, 1.2, site=other)
    assert not history.is_same
    assert sentences(history)[-1].startswith('Note: the bag recorded other tracks here')


@pytest.mark.parametrize('reason', Reason)
def test_every_reason_has_its_words(reason):
    decisions = Decisions.build(
        0, position=[[0, 0, 0]], track_id=[4], other_id=[9], value=[1.5], limit=[2.5],
        cameras=[3], reason=[reason],
    )  # fmt: skip
    text = reason_of(decisions, 0, CAMERAS, Candidates.build(0))
    assert text.startswith('It') or text.startswith('No camera') or text.startswith('Track 9')
    assert text.endswith('.')
