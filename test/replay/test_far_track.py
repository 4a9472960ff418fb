"""A site in national coordinates is tracked as the same site near zero."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from drawn_hall import PERIOD_NS, walkers, write_hall
from far_hall import write_far_hall
from mctrack_ros.cli.main import app
from mctrack_ros.interfaces import Detections, Tracks, TrackStatus
from mctrack_ros.recording import BagReader, BagWriter, write_mot_text
from mctrack_ros.replay.lockstep import ReplayError
from mctrack_ros.replay.track import track_bag

pytestmark = pytest.mark.xdist_group('replay')

OFFSETS = [(389000.0, 5820000.0), (2000123.4, 2000456.7)]
SECONDS = 4.0
MM = 1e-3


def mctrack(*arguments):
    result = CliRunner().invoke(app, [*map(str, arguments)], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.output


def rows_of(bag, topic, kind):
    with BagReader(bag) as reader:
        return [rows for rows, _ in reader.rows(topic, kind)]


@pytest.fixture(scope='module')
def halls(tmp_path_factory):
    """Return by offset: the site, what was tracked with it, and the truth in its coordinates."""
    folder = tmp_path_factory.mktemp('far')
    bag, _ = write_hall(folder, SECONDS)
    made = {}
    for index, offset in enumerate([(0.0, 0.0), *OFFSETS]):
        place = folder / f'site{index}'
        site = write_far_hall(place, offset)
        mctrack('track', bag, '--out', place / 'out', '--site', place / 'site.yaml')
        stamps = [rows.stamp_ns for rows in rows_of(place / 'out/bag', '/tracks', Tracks)]
        instants = [
            Tracks.build(
                stamp_ns,
                track_id=np.arange(1, 4),
                status=np.ones(3),
                position=np.column_stack([walkers(stamp_ns * 1e-9 - 1000), np.zeros(3)]),
            )
            for stamp_ns in stamps
        ]
        truth = place / 'truth.txt'
        write_mot_text(truth, instants, PERIOD_NS)
        lines = np.loadtxt(truth, delimiter=',')
        lines[:, 7:9] += offset
        np.savetxt(truth, lines, fmt=['%d', '%d', *['%g'] * 5, *['%.4f'] * 3], delimiter=',')
        made[offset] = site, place / 'out', truth
    return made


@pytest.mark.parametrize('offset', OFFSETS)
def test_tracks_on_the_topics_are_those_of_the_near_site_to_the_millimetre(halls, offset):
    (_, near, _), (site, far, _) = halls[0.0, 0.0], halls[offset]
    shift = np.array([*np.subtract(site.origin, offset), 0.0])
    for topic, kind in (('/tracks', Tracks), ('/north/detections', Detections)):
        pairs = zip(
            rows_of(far / 'bag', topic, kind), rows_of(near / 'bag', topic, kind), strict=True
        )
        for rows, wanted in pairs:
            assert rows.track_id.tolist() == wanted.track_id.tolist()
            np.testing.assert_allclose(rows.position + shift, wanted.position, rtol=0, atol=MM)
            np.testing.assert_allclose(rows.covariance, wanted.covariance, rtol=0.01, atol=1e-6)
    for rows in rows_of(far / 'bag', '/tracks', Tracks)[-25:]:
        assert np.count_nonzero(rows.status == TrackStatus.CONFIRMED) == 3


@pytest.mark.parametrize('offset', OFFSETS)
def test_text_is_in_the_coordinates_of_the_files(halls, offset):
    near, far = (
        np.loadtxt(halls[each][1] / 'tracks.txt', delimiter=',') for each in ((0.0, 0.0), offset)
    )
    np.testing.assert_array_equal(far[:, :2], near[:, :2])
    np.testing.assert_allclose(far[:, 7:9] - offset, near[:, 7:9], rtol=0, atol=MM)
    near, far = (
        np.loadtxt(halls[each][1] / 'tracks.csv', delimiter=',', skiprows=1, usecols=(3, 4))
        for each in ((0.0, 0.0), offset)
    )
    np.testing.assert_allclose(far - offset, near, rtol=0, atol=MM)


@pytest.mark.parametrize('offset', OFFSETS)
@pytest.mark.parametrize('tracks', ['', 'bag', 'tracks.txt'])
def test_scores_are_those_of_the_near_site(halls, tmp_path, offset, tracks):
    scores = []
    for each in ((0.0, 0.0), offset):
        _, out, truth = halls[each]
        mctrack('evaluate', truth, out / tracks, '--json', tmp_path / 'scores.json')
        scores.append(json.loads((tmp_path / 'scores.json').read_text())['figures'])
    near, far = scores
    assert near['mota'] > 0.5
    assert far == pytest.approx(near, abs=MM, nan_ok=True)


def test_an_area_is_scored_in_the_coordinates_of_the_files(halls, tmp_path):
    scores = []
    for each in ((0.0, 0.0), OFFSETS[0]):
        _, out, truth = halls[each]
        low, high = np.array([-3.03, -4.5]) + each, np.array([3.53, 3.0]) + each
        area = ','.join(f'{value:.12g}' for value in (*low, *high))
        options = (f'--area={area}', '--json', tmp_path / 'scores.json')
        mctrack('evaluate', truth, out, *options)
        scores.append(json.loads((tmp_path / 'scores.json').read_text())['figures'])
    near, far = scores
    assert 0 < near['mota'] < 1
    assert far['mota'] == pytest.approx(near['mota'], abs=0.02)


def test_own_positions_are_taken_in_the_coordinates_of_the_files(halls, tmp_path):
    told = []
    for offset in ((0.0, 0.0), OFFSETS[0]):
        site, _, _ = halls[offset]
        rows = [
            f'{0.04 * index:.2f},{x + offset[0]:.4f},{y + offset[1]:.4f},0.9'
            for index in range(10)
            for x, y in walkers(0.04 * index)
        ]
        seen = tmp_path / 'seen.csv'
        seen.write_text('\n'.join(['time,x,y,score', *rows]) + '\n')
        folder = tmp_path / f'{offset[0]:.0f}'
        site_file = halls[offset][1].parent / 'site.yaml'
        mctrack('import-detections', folder, f'south={seen}', '--site', site_file)
        shift = np.append(np.subtract(site.origin, offset), 0.0)
        instants = rows_of(folder, '/south/detections', Detections)
        told.append(np.concatenate([each.position + shift for each in instants]))
    near, far = told
    assert len(near) == 30
    np.testing.assert_allclose(far, near, rtol=0, atol=MM)


def test_a_truth_bag_tells_from_its_own_origin(halls, tmp_path):
    offset = OFFSETS[0]
    _, out, _ = halls[offset]
    for name, origin in (('same', None), ('other', [388000.0, 5820000.0])):
        shift = np.subtract(offset, origin or offset)
        with BagWriter(tmp_path / name) as writer:
            if origin:
                writer.write_text('/site', json.dumps({'origin': origin}), 10**12)
            for rows in rows_of(out / 'bag', '/tracks', Tracks):
                moved = rows.replace(position=rows.position + np.append(shift, 0.0))
                writer.write_rows('/truth/tracks', moved, 'map')
        mctrack('evaluate', tmp_path / name, out, '--json', tmp_path / 'scores.json')
        figures = json.loads((tmp_path / 'scores.json').read_text())['figures']
        assert figures['mota'] == 1.0
        assert figures['mean_distance'] < MM


def test_recorded_detections_are_tracked_from_their_own_origin_alone(halls, tmp_path):
    site, out, _ = halls[OFFSETS[0]]
    track_bag(out / 'bag', tmp_path / 'again', site)
    text = 'tracks.txt'
    assert (tmp_path / 'again' / text).read_bytes() == (out / text).read_bytes()
    other = write_far_hall(tmp_path / 'other', OFFSETS[0], origin='388000,5820000')
    with pytest.raises(ReplayError, match='set origin: 389000,5820000 in the site'):
        track_bag(out / 'bag', tmp_path / 'wrong', other)
