"""Which tracker a site gets that names none."""

import re

import cv2
import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation

from mctrack_ros.config import ConfigError
from mctrack_ros.ground.xml_files import tag, write_lines
from mctrack_ros.site.choice import with_tracker
from mctrack_ros.site.site import load_site

SIZE, FOCAL_PX = (640, 480), 600.0


def write_camera(path, at):
    """Write a camera at (3,) m that looks at the origin, as a Tsai file (mm)."""
    at = np.asarray(at, float)
    forward = -at / np.linalg.norm(at)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    rotation = np.stack([right, np.cross(forward, right), forward])
    tx, ty, tz = (-1000 * rotation @ at).tolist()
    rx, ry, rz = Rotation.from_matrix(rotation).as_euler('xyz').tolist()
    width, height = (str(side) for side in SIZE)
    write_lines(
        path,
        [
            tag('Camera', end='', name=path.stem),
            tag('Geometry', width=width, height=height, dpx=0.01, dpy=0.01),
            tag('Intrinsic', focal=FOCAL_PX * 0.01, kappa1=0.0, cx=320.0, cy=240.0, sx=1.0),
            tag('Extrinsic', tx=tx, ty=ty, tz=tz, rx=rx, ry=ry, rz=rz),
            '</Camera>',
        ],
    )


@pytest.fixture
def site(tmp_path):
    """Return what writes and reads a site of two cameras that look at one place."""

    def read(away=8.0, height=3.0, pipeline=None, own=None, **fusion):
        cameras = {}
        for name, at in {'east': (away, 0.5, height), 'south': (0.3, -away, height)}.items():
            write_camera(tmp_path / f'{name}.xml', at)
            cameras[name] = {'calibration': f'{name}.xml'}
            cameras[name] |= {'image_width': SIZE[0], 'image_height': SIZE[1]}
        cameras['east'] |= own or {}
        content = {'cameras': cameras, 'fusion': fusion, 'pipeline': pipeline or {}}
        (tmp_path / 'site.yaml').write_text(yaml.safe_dump(content))
        return load_site(tmp_path / 'site.yaml')

    return read


def test_cameras_that_share_a_view_of_large_people_find_them_jointly(site):
    given = site(batching={'period': 0.2}, management={'coast_time': 2.0})
    chosen, why = with_tracker(given)
    assert chosen.fusion.tracker == 'occupancy'
    assert chosen.fusion.batching.period == 0.2
    assert chosen.fusion.management.coast_time == 2.0
    assert 'occupancy' in why
    assert chosen.cameras == given.cameras


@pytest.mark.parametrize('away', [8.0, 40.0])
def test_vehicles_are_found_jointly_however_small_people_are(site, away):
    given = site(
        away=away, pipeline={'tracker': {'vehicles': True}}, management={'coast_time': 2.0}
    )
    chosen, why = with_tracker(given)
    assert chosen.fusion.tracker == 'vehicles'
    assert chosen.fusion.management.coast_time == 2.0
    assert 'pipeline.tracker.vehicles' in why


def test_a_named_tracker_stays(site):
    given = site(tracker='joint')
    assert with_tracker(given) == (given, 'tracker joint: as the site says')
    given = site(tracker='occupancy')
    assert with_tracker(given) == (given, 'tracker occupancy: as the site says')


@pytest.mark.parametrize(
    ('settings', 'reason'),
    [
        ({'away': 40.0, 'height': 15.0}, 'people are about'),
        ({'pipeline': {'local_tracker': 'silhouettes'}}, 'local_tracker: event_tracker'),
        ({'own': {'boxes_topic': 'boxes'}}, 'masks, which east does not send'),
        ({'untrusted': 'east'}, 'not untrusted ones'),
        ({'untrusted': 'east', 'pipeline': {'tracker': {'vehicles': True}}}, 'not untrusted ones'),
    ],
    ids=['distant people', 'silhouettes', 'boxes', 'untrusted', 'untrusted, vehicles'],
)
def test_what_masks_do_not_suit_keeps_the_joint_tracker(site, settings, reason):
    given = site(**settings)
    chosen, why = with_tracker(given)
    assert chosen is given
    assert 'tracker joint' in why
    assert reason in why


def test_own_detections_are_no_masks(site):
    given = site()
    assert with_tracker(given)[0].fusion.tracker == 'occupancy'
    chosen, why = with_tracker(given, own_detections=True)
    assert chosen is given
    assert why == 'tracker joint: occupancy needs masks, which own detections do not have'


@pytest.mark.parametrize('tracker', ['occupancy', 'vehicles', 'likelihood_grid', 'belief'])
def test_a_named_tracker_that_takes_more_than_boxes_is_refused(site, tracker):
    with pytest.raises(ConfigError, match=r'cameras\.east\.\S* .*\bdetections') as refused:
        site(own={'boxes_topic': 'boxes'}, tracker=tracker)
    assert f'fusion.tracker {tracker} takes detections and' in str(refused.value)
    assert '\n' not in str(refused.value)


def test_cameras_that_look_apart_keep_the_joint_tracker(site, tmp_path):
    given = site()
    text = (tmp_path / 'south.xml').read_text()
    moved = re.sub('tx="([^"]+)"', lambda found: f'tx="{float(found[1]) + 1e5}"', text)
    (tmp_path / 'south.xml').write_text(moved)
    chosen, why = with_tracker(given)
    assert chosen is given
    assert 'tracker joint: two cameras or more see 0% of the ground' in why


def test_one_camera_keeps_the_joint_tracker(site, tmp_path):
    site()
    content = yaml.safe_load((tmp_path / 'site.yaml').read_text())
    del content['cameras']['south']
    (tmp_path / 'site.yaml').write_text(yaml.safe_dump(content))
    given = load_site(tmp_path / 'site.yaml')
    assert with_tracker(given) == (given, 'tracker joint: occupancy needs two cameras or more')


def by_homographies(site, folder, away, height):
    """Return the site whose calibrations are the homographies of those of another, as matrices."""
    given = site(away=away, height=height)
    content = yaml.safe_load((folder / 'site.yaml').read_text())
    for name, mapping in given.views().mappings.items():
        shown = mapping.visible_ground()
        matrix, _ = cv2.findHomography(mapping.image_from_ground(shown), shown)
        path = folder / f'{name}.yaml'
        path.write_text(yaml.safe_dump({'ground_from_image': matrix.tolist()}))
        content['cameras'][name]['calibration'] = path.name
    (folder / 'site.yaml').write_text(yaml.safe_dump(content))
    return load_site(folder / 'site.yaml')


def test_homographies_that_tell_how_high_people_look_will_do(site, tmp_path):
    chosen, why = with_tracker(by_homographies(site, tmp_path, away=8.0, height=3.0))
    assert chosen.fusion.tracker == 'occupancy'
    assert 'tracker occupancy' in why


def test_homographies_from_above_keep_the_joint_tracker(site, tmp_path):
    given = by_homographies(site, tmp_path, away=0.6, height=4.0)
    chosen, why = with_tracker(given)
    assert chosen is given
    assert "occupancy needs every camera's pose" in why
    assert 'south' in why
