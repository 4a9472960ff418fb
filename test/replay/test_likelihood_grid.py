"""People are tracked by the likelihoods of a bag's cameras, and again from what was recorded."""

from dataclasses import replace

import numpy as np
import pytest
import yaml

from drawn_hall import walkers, write_hall
from mctrack_ros.config import ConfigError
from mctrack_ros.interfaces import Detections, Foreground, Likelihood, Tracks, TrackStatus
from mctrack_ros.recording import BagReader
from mctrack_ros.replay.drive import drive
from mctrack_ros.replay.proof.verify import Replay, verify_bag
from mctrack_ros.replay.recorded import recorded_ticks
from mctrack_ros.replay.track import Source, track_bag
from mctrack_ros.site.site import load_site

pytestmark = pytest.mark.xdist_group('replay')
CLOSE = {'east': (13.0, 1.0, 7.0), 'north': (-1.0, -13.0, 7.0), 'south': (1.0, 13.0, 7.0)}
TOPICS = ('/tracks', '/feedback', '/ticks', '/north/likelihood', '/north/detections')


@pytest.fixture(scope='module')
def tracked(tmp_path_factory):
    """Return a tracked bag, its site and where it lies."""
    folder = tmp_path_factory.mktemp('likelihood_grid')
    bag, _ = write_hall(folder, seconds=4.0, positions=CLOSE)
    path = folder / 'site.yaml'
    content = yaml.safe_load(path.read_text()) | {'area': '-6,-5,6,5'}
    content['pipeline'] = {
        'local_tracker': 'likelihood_grid',
        'background': {'learning_s': 1.0},
        'grid': {'person_width': 0.6},
    }
    # people are drawn 0.6 m wide, and JPEG colours two more pixels on either side
    content['fusion'] = {'tracker': 'likelihood_grid', 'person_width': 0.75}
    path.write_text(yaml.safe_dump(content))
    site = load_site(path)
    summary = track_bag(Source(bag, first_pass=False), folder / 'out', site)
    assert summary.ticks == 100
    for camera in site.camera_names:
        assert 25 <= summary.cameras[f'{camera}.unsettled'] <= 30
    return folder / 'out/bag', site, folder


def rows(bag, topic, kind):
    with BagReader(bag) as reader:
        return [each for each, _ in reader.rows(topic, kind)]


def data(bag, topic):
    with BagReader(bag) as reader:
        return [message for _, _, message, _ in reader.serialized([topic])]


def test_with_backgrounds_of_the_whole_recording_likelihoods_begin_with_the_first_image(tracked):
    _, site, folder = tracked
    summary = track_bag(folder / 'bag', folder / 'whole', site)
    for camera in site.camera_names:
        likelihood = rows(folder / 'whole/bag', f'/{camera}/likelihood', Likelihood)
        assert [len(each) for each in likelihood] == [1600] * 100
        assert summary.cameras[f'{camera}.unsettled'] == 0


def test_people_are_found_where_they_walk(tracked):
    for each in rows(tracked[0], '/tracks', Tracks)[-25:]:
        each = each.select(each.status == TrackStatus.CONFIRMED)
        people = walkers(each.stamp_ns * 1e-9 - 1000)
        gaps = np.linalg.norm(each.position[:, None, :2] - people, axis=2)
        assert gaps.shape == (3, 3)
        assert gaps.min(axis=0).max() < 0.5


def test_cameras_tell_likelihoods_masks_and_the_targets_in_view(tracked):
    bag, site, _ = tracked
    for camera in site.camera_names:
        likelihood = rows(bag, f'/{camera}/likelihood', Likelihood)
        assert [len(each) for each in likelihood] == [0] * 30 + [1600] * 70
        assert likelihood[-1].shape == (40, 40)
        np.testing.assert_allclose(likelihood[-1].position[0, :2], [-5.85, -4.875])
        assert np.nanmax(likelihood[-1].log_likelihood) > -2.5
        masks = rows(bag, f'/{camera}/foreground/compressed', Foreground)
        assert len(masks[-1])
        seen = rows(bag, f'/{camera}/detections', Detections)[-1]
        assert len(seen) == 3
        assert seen.template.any(axis=1).sum() >= 2
        known = rows(bag, '/tracks', Tracks)[-1].track_id
        assert set(seen.track_id.tolist()) <= set(known.tolist())


def test_the_same_bag_gives_the_same_bytes_however_many_processes(tracked):
    bag, site, folder = tracked
    source = Source(folder / 'bag', first_pass=False)
    track_bag(source, folder / 'alone', site, processes=1)
    for topic in TOPICS:
        assert data(bag, topic) == data(folder / 'alone/bag', topic), topic


def test_fusing_the_recorded_messages_again_gives_the_same_bytes(tracked):
    bag, site, folder = tracked
    track_bag(bag, folder / 'again', site)
    for topic in TOPICS[:3]:
        assert data(bag, topic) == data(folder / 'again/bag', topic)


def test_by_edges_alone_no_calibrations_are_needed(tracked):
    bag, site, folder = tracked
    content = yaml.safe_load((folder / 'site.yaml').read_text())
    content['fusion'] = {'tracker': 'likelihood_grid', 'layers': 'edges'}
    path = folder / 'edges.yaml'
    path.write_text(yaml.safe_dump(content))
    config = load_site(path).fusion
    with BagReader(bag) as reader:
        ticks = recorded_ticks(reader, site.camera_names, config)
        last = [each.output.tracks for each in drive(config, site.camera_names, ticks)][-1]
    last = last.select(last.status == TrackStatus.CONFIRMED)
    people = walkers(last.stamp_ns * 1e-9 - 1000)
    gaps = np.linalg.norm(last.position[:, None, :2] - people, axis=2)
    assert gaps.min(axis=0).max() < 0.6


def test_a_dazzled_camera_s_edges_do_not_count_either(tracked):
    bag, site, _ = tracked
    mask = np.full((120, 160), 255, np.uint8)

    def dazzled(ticks, is_told):
        for tick in ticks:
            messages = []
            for each in tick.messages:
                if each.camera == 'north' and len(each.rows):
                    nobody = each.rows.likelihood.select(np.arange(0))
                    everybody = each.rows.likelihood.replace(
                        log_likelihood=np.zeros(len(each.rows), np.float32)
                    )
                    rows = replace(
                        each.rows,
                        likelihood=everybody if is_told else nobody,
                        foreground=Foreground(each.rows.stamp_ns, mask),
                    )
                    each = replace(each, rows=rows)
                messages.append(each)
            yield replace(tick, messages=tuple(messages))

    found = []
    for is_told in (True, False):
        with BagReader(bag) as reader:
            ticks = recorded_ticks(reader, site.camera_names, site.fusion)
            given = dazzled(ticks, is_told)
            driven = drive(site.fusion, site.camera_names, given, views=site.views)
            out = [each.output for each in driven]
        assert out[-1].left_out.keys() == {'north'}
        found.append([each.tracks for each in out])
    for with_edges, without in zip(*found):
        assert with_edges.track_id.tolist() == without.track_id.tolist()
        np.testing.assert_array_equal(with_edges.position, without.position)


def test_a_site_without_an_area_or_with_other_cameras_is_refused(tracked):
    folder = tracked[2]
    content = yaml.safe_load((folder / 'site.yaml').read_text())
    path = folder / 'wrong.yaml'
    path.write_text(yaml.safe_dump({key: content[key] for key in content if key != 'area'}))
    with pytest.raises(ConfigError, match='name the area'):
        load_site(path).cameras['north'].open('north')
    content['cameras']['south']['pipeline'] = {'local_tracker': 'event_tracker'}
    path.write_text(yaml.safe_dump(content))
    with pytest.raises(ConfigError, match='takes detections and likelihood and foreground'):
        load_site(path)


def test_a_replay_that_goes_on_from_a_state_gives_the_same_tracks(tracked):
    bag, _, _ = tracked
    first, state = verify_bag(bag, Replay(until_s=2.0))
    second, _ = verify_bag(bag, Replay(state=state))
    assert first.is_same
    assert second.is_same
    assert second.stored == second.digest
    assert first.ticks + second.ticks == 100
