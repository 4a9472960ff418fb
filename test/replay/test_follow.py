"""A detector's boxes in the images of cameras that pan, tilt and zoom are put on the ground."""

import dataclasses

import numpy as np
import pytest
import yaml

from mctrack_ros.interfaces import Detections, Tracks, TrackStatus
from mctrack_ros.recording import BagReader
from mctrack_ros.recording.tables.box_files import TextClock, read_boxes
from mctrack_ros.recording.tables.columns import TableError
from mctrack_ros.replay.detections.follow import followed
from mctrack_ros.replay.detections.import_detections import import_detections
from mctrack_ros.replay.track import track_bag
from mctrack_ros.simulation import PtzScenario
from mctrack_ros.simulation.calibration import write_calibration
from mctrack_ros.simulation.recording import simulate
from mctrack_ros.site.site import load_site

pytestmark = pytest.mark.xdist_group('replay')
SCENARIO = PtzScenario(seed=21, duration_s=4)
CAMERAS = ('cam1', 'cam2')


@pytest.fixture(scope='module')
def filmed(tmp_path_factory):
    """Return a folder with a match, a site and what a detector saw, and that and the site."""
    folder = tmp_path_factory.mktemp('follow')
    simulate(SCENARIO, folder / 'match', processes=1)
    write_calibration(SCENARIO, folder / 'calibration')
    cameras = {
        name: {
            'grid': f'calibration/{name}.xml',
            'method': 'homography',
            'lines': 'calibration/lines.yaml',
        }
        for name in CAMERAS
    }
    moving = {'local_tracker': 'belief', 'moving': True}
    site = {'cameras': cameras, 'pipeline': moving, 'area': '0,0,105,68'}
    (folder / 'site.yaml').write_text(yaml.safe_dump(site))
    sightings = {name: seen(folder, name) for name in CAMERAS}
    return folder, load_site(folder / 'site.yaml'), sightings


def seen(folder, camera):
    """Return the true boxes of a camera as a detector gives them: with noise, some missing."""
    rng = np.random.default_rng(5)
    lines = ['stamp_ns,score,left,top,width,height']
    for rows in read(folder / 'match', f'/truth/{camera}/detections', Detections):
        box = rows.box[rng.random(len(rows)) < 0.9]
        box = np.maximum(box + 0.03 * box[:, 3:] * rng.normal(size=box.shape), [-20, -20, 2, 6])
        lines += [
            f'{rows.stamp_ns},0.9,' + ','.join(f'{side:.2f}' for side in each) for each in box
        ]
    path = folder / f'{camera}.csv'
    path.write_text('\n'.join(lines))
    return read_boxes(path, TextClock())


def read(bag, topic, kind):
    with BagReader(bag) as reader:
        return [rows for rows, _ in reader.rows(topic, kind)]


def test_boxes_are_tracked_where_people_are(filmed):
    folder, site, sightings = filmed
    done = import_detections(sightings, site, folder / 'seen', images=folder / 'match')
    assert [each.lost for each in done.values()] == [0, 0]
    assert track_bag(folder / 'seen', folder / 'out', site).ticks == SCENARIO.steps
    tracks = read(folder / 'out/bag', '/tracks', Tracks)[-1]
    tracks = tracks.select(tracks.status == TrackStatus.CONFIRMED)
    people = read(folder / 'match', '/truth/tracks', Tracks)[-1].position
    gap = np.linalg.norm(people[:, None, :2] - tracks.position[:, :2], axis=2)
    assert len(tracks) > 15
    assert np.median(gap.min(axis=0)) < 0.5


def test_a_calibration_says_how_well_it_is_known(filmed):
    folder, site, sightings = filmed
    looks = followed('cam1', site.cameras['cam1'], folder / 'match', sightings['cam1'])
    place = np.array([(50.0, 20.0), (50.0, 60.0)])
    near, far = (
        np.linalg.eigvalsh(each)[-1]
        for each in looks[SCENARIO.stamp_ns(50)].calibration_covariance(place)
    )
    assert 0 < near < far < 1


def test_boxes_of_cameras_that_move_need_their_images(filmed):
    folder, site, sightings = filmed
    with pytest.raises(TableError, match='--images'):
        import_detections(sightings, site, folder / 'no')
    with pytest.raises(TableError, match='no images on /cam1/image_raw'):
        import_detections(sightings, site, folder / 'no', images=folder / 'seen')


def test_an_image_that_is_not_there_is_left_out(filmed):
    folder, site, sightings = filmed
    late = sightings['cam1']
    late = dataclasses.replace(late, stamp_ns=late.stamp_ns + 2_000_000_000)
    done = import_detections({'cam1': late}, site, folder / 'late', images=folder / 'match')
    assert done['cam1'].lost == SCENARIO.steps // 2
    assert done['cam1'].images == SCENARIO.steps // 2


def test_cameras_that_move_must_be_pinholes(filmed):
    folder, site, sightings = filmed
    fitted = dataclasses.replace(site.cameras['cam1'], method='fitted')
    with pytest.raises(TableError, match='method: homography'):
        followed('cam1', fitted, folder / 'match', sightings['cam1'])
