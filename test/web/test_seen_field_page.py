"""A field of view drawn on the camera's image, in headless Chromium, by a real mouse."""

import re

import cv2
import numpy as np
import pytest

from mctrack_ros.ground import read_grid
from mctrack_ros.simulation import Scenario, pitch5_cameras
from mctrack_ros.simulation.pitch.stadium import empty_image
from web.desk import ON_SCREEN, PATIENCE_MS
from web.fields import write_site

SEEN, GROUND = 0, 1
CORNERS = [(8.0, 10.0), (40.0, 30.0), (40.0, 50.0), (8.0, 50.0)]
MENDED = (56.0, 58.0)

pytestmark = [pytest.mark.browser, pytest.mark.xdist_group('browser')]


@pytest.fixture(scope='module')
def cameras():
    return pitch5_cameras(Scenario())[:2]


@pytest.fixture(scope='module')
def folder(tmp_path_factory, cameras):
    """Return a folder with a site and an image of each of its cameras."""
    path = tmp_path_factory.mktemp('seen')
    write_site(path)
    for camera in cameras:
        image = empty_image(camera, np.random.default_rng(1))
        cv2.imwrite(str(path / f'{camera.name}.png'), image)
    return path


@pytest.fixture
def page(browser, serve, folder):
    sources = ['--source', 'cam1=cam1.png', '--source', 'cam2=cam2.png']
    with serve(folder, 'coverage', 'two.yaml', '--cell', '2', '--web', *sources) as address:
        page = browser.new_page(viewport={'width': 1440, 'height': 900})
        page.set_default_timeout(PATIENCE_MS)
        page.on('pageerror', lambda error: pytest.fail(f'the page fails: {error}'))
        page.goto(address)
        page.wait_for_selector('.image .field.current')
        yield page
        page.close()


def on_screen(page, camera, place):
    """Return where on the screen a camera's image shows a place on the ground."""
    (x, y), *_ = camera.project([(*place, 0.0)]).tolist()
    return page.evaluate(ON_SCREEN, [SEEN, x, y])


def drag(page, start, end):
    page.mouse.move(*start)
    page.mouse.down()
    page.mouse.move((start[0] + end[0]) / 2, (start[1] + end[1]) / 2)
    page.mouse.move(*end)
    page.mouse.up()


def corners_are(page, board, count):
    page.wait_for_function(
        f"document.querySelectorAll('.{board} .mark.corner, .{board} .mark.chosen').length"
        f' == {count}'
    )


def test_a_field_is_drawn_on_the_image_mended_and_saved(page, cameras, folder):
    first, _ = cameras
    page.get_by_role('button', name='cam2', exact=True).click()
    page.get_by_text('seen by cam2').wait_for()
    page.get_by_role('button', name='cam1', exact=True).click()
    page.get_by_text('seen by cam1').wait_for()
    before = page.locator('.verdict .headline').inner_text()
    for count, corner in enumerate(CORNERS, 1):
        page.mouse.click(*on_screen(page, first, corner))
        for board in ('image', 'ground'):
            corners_are(page, board, count)
    page.get_by_text(re.compile('^9[4-7][0-9]$')).first.wait_for()
    assert page.locator('.verdict .headline').inner_text() != before

    page.mouse.click(*page.evaluate(ON_SCREEN, [SEEN, 400, 3]))
    page.get_by_text('above the horizon; nothing was changed').wait_for()
    corners_are(page, 'image', 4)
    place = on_screen(page, first, CORNERS[2])
    drag(page, place, page.evaluate(ON_SCREEN, [SEEN, 300, 3]))
    page.get_by_text(re.compile(r'^\((299|300|301), .*above the horizon')).wait_for()
    page.wait_for_function(
        """([x, y]) => [...document.querySelectorAll('.image .mark.corner .dot')].some((dot) => {
          const box = dot.getBoundingClientRect();
          return Math.hypot(box.x + box.width / 2 - x, box.y + box.height / 2 - y) < 2;
        })""",
        arg=place,
    )
    drag(page, place, on_screen(page, first, MENDED))
    page.get_by_text(re.compile('^12[0-9][0-9]$')).first.wait_for()
    page.get_by_text('fused error').click()
    page.get_by_role('button', name='Save').click()
    page.get_by_text('Saved into the grids of cam1').first.wait_for()

    found = sorted(map(tuple, read_grid(folder / 'cam1.xml').fov.tolist()))
    wanted = sorted([CORNERS[0], CORNERS[1], MENDED, CORNERS[3]])
    assert len(found) == 4
    assert max(abs(a - b) for one, two in zip(found, wanted) for a, b in zip(one, two)) < 1.0
    assert read_grid(folder / 'cam2.xml').fov is None
