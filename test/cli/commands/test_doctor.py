"""What `mctrack doctor` finds, and what it says to do."""

import json

import numpy as np
import pytest
import yaml
from typer.testing import CliRunner

from drawn_hall import write_hall
from mctrack_ros.cli.main import app
from mctrack_ros.codec import image_message
from mctrack_ros.recording import ROSBAGS_CLASSES, BagWriter
from walker import IMAGE_FROM_WORLD, SIZE

START_NS = 1_700_000_000 * 10**9


@pytest.fixture
def examine(tmp_path):
    """Return a function that writes a site, and a bag of images, and has them examined."""

    def run(cameras=None, *, offset_s=None, period_s=0.04, count=40, size=SIZE, **keys):
        (tmp_path / 'matrix.yaml').write_text(
            yaml.safe_dump({'image_from_world': IMAGE_FROM_WORLD.tolist()})
        )
        own = {'calibration': 'matrix.yaml', 'image_width': SIZE[0], 'image_height': SIZE[1]}
        own['image_topic'] = 'image_raw'
        cameras = cameras or {'north': {}, 'south': {}, 'west': {}}
        content = {'cameras': {name: own | more for name, more in cameras.items()}} | keys
        (tmp_path / 'site.yaml').write_text(yaml.safe_dump(content))
        with BagWriter(tmp_path / 'bag', overwrite=True) as bag:
            for index in range(count):
                true_ns = START_NS + round(index * period_s * 1e9)
                for name in ('north', 'south', 'west'):
                    rng = np.random.default_rng(index)
                    image = rng.integers(90, 110, (size[1], size[0], 3)).astype(np.uint8)
                    stamp_ns = true_ns + round((offset_s or {}).get(name, 0.0) * 1e9)
                    message = image_message(image, ROSBAGS_CLASSES, stamp_ns, name)
                    bag.write(f'/{name}/image_raw', message, true_ns + 10_000_000)
        command = ['doctor', str(tmp_path / 'site.yaml'), str(tmp_path / 'bag')]
        done = CliRunner().invoke(app, [*command, '--json', str(tmp_path / 'found.json')])
        return done, json.loads((tmp_path / 'found.json').read_text())

    return run


def found(findings, severity):
    return {
        (each['about'], each['what'], each['remedy'])
        for each in findings
        if each['severity'] == severity
    }


def test_a_sound_site_has_notes_alone(examine):
    done, findings = examine()
    assert done.exit_code == 0
    assert {each['severity'] for each in findings} == {'note'}
    assert {each['about'] for each in findings} == {'north', 'south', 'west'}
    assert all('no image of the empty scene' in each['what'] for each in findings)
    assert '0 errors, 0 warnings, 3 notes' in done.output


def test_a_clock_that_is_off_is_named_with_its_offset(examine):
    done, findings = examine(offset_s={'south': 3600.0, 'west': 0.1})
    (south,) = [one for one in found(findings, 'warning') if one[0] == 'south']
    (west,) = [one for one in found(findings, 'warning') if one[0] == 'west']
    assert '40 messages are left out: their stamps lie 3600.000 s ahead' in south[1]
    assert 'its clock is 0.100 s ahead' in west[1]
    assert 'NTP or PTP' in south[2]
    assert done.exit_code == 0


def test_images_of_another_size_are_an_error(examine):
    done, findings = examine(size=(320, 240))
    errors = found(findings, 'error')
    assert {about for about, *_ in errors} == {'north', 'south', 'west'}
    assert all('320 x 240' in what and '192 x 144' in what for _, what, _ in errors)
    assert done.exit_code == 1


def test_a_camera_that_is_not_in_the_bag_is_an_error_that_says_what_is(examine):
    done, findings = examine({'north': {}, 'east': {}})
    ((about, what, _),) = found(findings, 'error')
    assert about == 'east'
    assert 'has no messages on /east/image_raw' in what
    assert done.exit_code == 1


@pytest.mark.parametrize(
    ('more', 'what'),
    [
        ({'calibration': 'absent.yaml'}, 'absent.yaml'),
        ({'mask': 'absent.png'}, 'mask'),
        ({'background': 'absent.png'}, 'background'),
        ({'calibration': ''}, 'name either a grid or a calibration'),
    ],
)
def test_files_that_cannot_be_used_are_errors(examine, more, what):
    done, findings = examine({'north': more, 'south': {}})
    ((about, text, _),) = found(findings, 'error')
    assert about == 'north'
    assert what in text
    assert done.exit_code == 1


def test_a_period_that_is_not_that_of_the_fastest_camera_is_a_warning(examine):
    _, findings = examine(period_s=0.2)
    ((_, what, remedy),) = found(findings, 'warning')
    assert 'every 0.2000 s, the period is 0.04 s' in what
    assert remedy == 'set fusion.batching.period to 0.2000'


def test_feedback_that_would_be_needed_too_early_is_an_error(examine):
    done, findings = examine(feedback_delay=0.01)
    assert any('feedback_delay is 0.01 s' in what for _, what, _ in found(findings, 'error'))
    assert done.exit_code == 1


def test_a_rendered_hall_is_in_order(tmp_path):
    from mctrack_ros.replay.doctor import Severity, examine_bag, examine_site

    bag, site = write_hall(tmp_path)
    findings = [*examine_site(site), *examine_bag(bag, site)]
    assert {each.severity for each in findings} <= {Severity.NOTE}
