import dataclasses
import json
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml

from mctrack_ros.config import ConfigError
from mctrack_ros.ground import read_grid, write_grid
from mctrack_ros.interfaces import MAX_CAMERAS
from mctrack_ros.perception import EventTrackerConfig
from mctrack_ros.replay.doctor import examine_bag, examine_site
from mctrack_ros.replay.lockstep import ReplayError, camera_tasks
from mctrack_ros.site.choice import with_tracker
from mctrack_ros.site.site import load_site
from mctrack_ros.web.live.backdrop import backdrop

CONFIG = Path(__file__).resolve().parents[2] / 'config'
HOMOGRAPHY = 'image_from_ground: [[20, 1, 300], [0.5, -8, 400], [0, 0.02, 1]]'


@pytest.fixture
def site(tmp_path):
    """Return a function that writes a site and reads it."""
    (tmp_path / 'view.yaml').write_text(HOMOGRAPHY)

    def make(**content):
        cameras = {'north': {'calibration': 'view.yaml'}}
        path = tmp_path / 'site.yaml'
        path.write_text(yaml.safe_dump({'cameras': cameras} | content))
        return load_site(path)

    return make


def test_the_shipped_site_has_five_cameras_that_all_read():
    pitch = load_site(CONFIG / 'pitch5.yaml')
    assert pitch.camera_names == ('cam1', 'cam2', 'cam3', 'cam4', 'cam5')
    for camera in pitch.cameras.values():
        assert camera.mapping().image_size == (768, 576)
        assert camera.ignore_mask() is None


def test_cells_stand_in_place_of_cameras(tmp_path):
    path = tmp_path / 'site.yaml'
    zone = {'gate': {'corners': [[0, 0], [4, 0], [4, 3]]}}
    content = {'cells': ['south', 'north'], 'origin': '10,0', 'zones': zone}
    path.write_text(yaml.safe_dump(content | {'fusion': {'cell_sigma': 0.3}}))
    loaded = load_site(path)
    assert loaded.camera_names == ('north', 'south')
    assert not loaded.cameras
    assert (loaded.fusion.tracker, loaded.fusion.cell_sigma) == ('cells', 0.3)
    assert loaded.origin == (10.0, 0.0)
    assert with_tracker(loaded) == (loaded, 'tracker cells: as the site says')
    assert loaded.values()['cells'] == ['north', 'south']
    assert backdrop(loaded)['cameras'] == []
    assert list(examine_site(loaded)) == []
    with pytest.raises(ReplayError, match='has cells, no cameras'):
        camera_tasks('bag', loaded)
    assert [each.severity for each in examine_bag('bag', loaded)] == ['error']


@pytest.mark.parametrize(
    ('content', 'reason'),
    [
        ({'cells': []}, 'expected a list of the namespaces'),
        ({'cells': 'north'}, 'expected a list of the namespaces'),
        ({'cells': ['north', 'north']}, 'different names'),
        ({'cells': ['no/rth']}, "'no/rth'"),
        (
            {'cells': ['north'], 'pipeline': {'reduction': 2}},
            'cells, or cameras and pipeline, not both',
        ),
        (
            {'cells': ['north'], 'cameras': {'cam1': {}}},
            'cells, or cameras and pipeline, not both',
        ),
        ({'cells': ['north'], 'fusion': {'tracker': 'joint'}}, 'joint takes cameras'),
        ({'cells': ['north'], 'fusion': 5}, 'fusion'),
        ({'cameras': {'cam1': {}}, 'fusion': {'tracker': 'cells'}}, 'cells takes cells'),
    ],
)
def test_what_are_no_cells_is_refused_with_the_reason(tmp_path, content, reason):
    (tmp_path / 'site.yaml').write_text(yaml.safe_dump(content))
    with pytest.raises(ConfigError, match=reason):
        load_site(tmp_path / 'site.yaml')


def test_cameras_are_sorted_and_share_settings_that_they_may_override(site):
    loaded = site(
        pipeline={'reduction': 2},
        cameras={'west': {'calibration': 'view.yaml'}, 'east': {'pipeline': {'reduction': 1}}},
    )
    assert loaded.camera_names == ('east', 'west')
    assert loaded.cameras['east'].pipeline.reduction == 1
    assert loaded.cameras['west'].pipeline.reduction == 2


def test_a_camera_with_another_tracker_takes_nothing_that_is_shared_of_the_first(site):
    loaded = site(
        pipeline={'local_tracker': 'silhouettes', 'silhouettes': {'holes': {'still_s': 3.0}}},
        cameras={
            'west': {'calibration': 'view.yaml'},
            'east': {'calibration': 'view.yaml', 'pipeline': {'local_tracker': 'event_tracker'}},
        },
    )
    assert loaded.cameras['west'].pipeline.silhouettes.holes.still_s == 3.0
    assert loaded.cameras['east'].pipeline == EventTrackerConfig()


def test_paths_are_relative_to_the_file(site, tmp_path):
    assert site().cameras['north'].calibration == str(tmp_path / 'view.yaml')


@pytest.mark.parametrize(
    ('content', 'reason'),
    [
        ({'fussion': {}}, 'unknown key fussion'),
        ({'fusion': {'perriod': 1}}, 'unknown key fusion.perriod'),
        ({'cameras': {}}, 'name at least one camera'),
        ({'cameras': None}, 'name at least one camera'),
        ({'cameras': {'north': None}}, 'cameras.north is None, expected a mapping'),
        ({'cameras': {'north': {'gird': 'a.xml'}}}, 'unknown key cameras.north.gird'),
        ({'cameras': {'1st': {}}}, "camera '1st': expected letters, digits"),
        ({'cameras': {'a/b': {}}}, "camera 'a/b'"),
        ({'cameras': {'caméra': {}}}, "camera 'caméra'"),
        ({'cameras': {3: {}}}, 'camera 3'),
        ({'cameras': {f'c{i}': {} for i in range(MAX_CAMERAS + 1)}}, 'expected at most 32'),
        ({'feedback_delay': 'long'}, "feedback_delay is 'long', expected a number"),
        ({'pipeline': {'reduction': 99}}, 'cameras.north.pipeline.reduction is 99'),
        ({'pipeline': [1]}, 'pipeline is'),
        (
            {'pipeline': {'local_tracker': 'silhouettes', 'reduction': 2}},
            'cameras.north.pipeline.reduction belongs to local_tracker event_tracker, but '
            'cameras.north.pipeline.local_tracker is silhouettes',
        ),
        ({'fusion': {'motion': {'calm_time': 1}}}, 'fusion.motion.calm_time belongs to model int'),
        ({'area': '0,0,5'}, "area is '0,0,5', expected x0,y0,x1,y1"),
        ({'area': '0,0,9,9,9,0,0,5'}, 'the area crosses or touches itself near'),
    ],
)
def test_wrong_sites_are_refused_by_file_and_key(site, content, reason):
    with pytest.raises(ConfigError, match=reason) as refusal:
        site(**content)
    assert 'site.yaml: ' in str(refusal.value)
    assert '\n' not in str(refusal.value)


@pytest.mark.parametrize('text', ['[1, 2', 'just a word', ''])
def test_files_that_hold_no_site_are_refused(tmp_path, text):
    (tmp_path / 'site.yaml').write_text(text)
    with pytest.raises(ConfigError, match=r'site\.yaml'):
        load_site(tmp_path / 'site.yaml')


def test_a_missing_site_is_named(tmp_path):
    with pytest.raises(ConfigError, match=r'nowhere.yaml: No such file'):
        load_site(tmp_path / 'nowhere.yaml')


@pytest.mark.parametrize('files', [{}, {'grid': 'a.xml', 'calibration': 'b.yaml'}])
def test_a_camera_needs_exactly_one_calibration(site, files):
    with pytest.raises(ConfigError, match='either a grid or a calibration'):
        site(cameras={'north': files}).cameras['north'].mapping()


def test_a_background_must_have_the_images_size(site, tmp_path):
    cv2.imwrite(str(tmp_path / 'empty.png'), np.zeros((10, 12, 3), np.uint8))
    reason = 'background .*empty.png is 12 x 10, expected 768 x 576'
    with pytest.raises(ConfigError, match=reason):
        site(cameras={'north': {'background': 'empty.png'}}).cameras['north'].open('north')


def test_a_background_that_is_missing_is_told_from_one_that_is_no_image(site, tmp_path):
    settings = site(cameras={'north': {'background': 'empty.png'}}).cameras['north']
    with pytest.raises(ConfigError, match=r'background .*empty.png does not exist'):
        settings.open('cam1')
    (tmp_path / 'empty.png').write_text('no image')
    with pytest.raises(ConfigError, match=r'empty.png is no image that OpenCV reads'):
        settings.open('cam1')


def test_a_mask_must_have_the_images_size(site, tmp_path):
    cv2.imwrite(str(tmp_path / 'mask.png'), np.full((10, 10), 255, np.uint8))
    with pytest.raises(ConfigError, match=r'mask.png is 10 x 10, expected 768 x 576'):
        site(cameras={'north': {'mask': 'mask.png'}}).cameras['north'].ignore_mask()


def test_the_description_decodes_a_bag_and_changes_with_the_settings(site):
    one, other = (json.loads(site(feedback_delay=d).description(1)) for d in (0.08, 0.12))
    assert one['cameras'] == ['north']
    assert one['codes']['TrackStatus']['CONFIRMED'] == 1
    assert one['layout_version'] == 1
    assert one['image_sizes'] == {'north': [768, 576]}
    assert one['configuration_hash'] != other['configuration_hash']


def test_a_run_over_a_recording_is_called_the_same_each_time(site):
    def run(began_ns, **settings):
        return json.loads(site(**settings).description(began_ns))['run']

    assert run(5) == run(5)
    assert len({run(5), run(6), run(5, feedback_delay=0.12)}) == 3


def test_a_grid_that_does_not_fit_is_doubted_and_others_are_not(site, tmp_path):
    grid = read_grid(CONFIG / 'pitch5' / 'cam5.xml')
    bare = dataclasses.replace(grid, image_size=None)
    write_grid(bare, tmp_path / 'grid.xml')
    sizes = {'right': (768, 576), 'wrong': (1536, 1152)}
    loaded = site(
        cameras={
            name: {'grid': 'grid.xml', 'image_width': width, 'image_height': height}
            for name, (width, height) in sizes.items()
        }
    )
    assert loaded.cameras['right'].doubt() == ''
    assert 'they fit images of 768 x 576 px' in loaded.cameras['wrong'].doubt()
    assert site().cameras['north'].doubt() == ''
