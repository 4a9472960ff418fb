"""The calibration page in headless Chromium, by a real mouse; run it alone with `-m browser`."""

import numpy as np
import pytest

from mctrack_ros.ground import mapping_from_grid, read_grid
from web.desk import IMAGE, PATIENCE_MS, Desk
from web.scenes import CAMERA, block, seen_points, write_scene_and_image

pytestmark = [pytest.mark.browser, pytest.mark.xdist_group('browser')]


@pytest.fixture
def folder(tmp_path):
    """Return a folder with an image and a scene."""
    write_scene_and_image(tmp_path)
    return tmp_path


@pytest.fixture
def address(browser, serve, folder):
    """Serve the page in the folder; return its address."""
    command = ['calibrate', 'cam1.png', 'scene.xml', '--camera', 'cam1', '--out', 'cam1.xml']
    with serve(folder, *command) as found:
        yield found


@pytest.fixture
def desk(browser, address):
    """Return the opened page; nothing it asks for lies on another machine."""
    asked = []
    page = browser.new_page(viewport={'width': 1440, 'height': 860})
    page.set_default_timeout(PATIENCE_MS)
    page.on('request', lambda request: asked.append(request.url))
    page.on('pageerror', lambda error: pytest.fail(f'the page fails: {error}'))
    page.goto(address)
    page.wait_for_selector('.mark')
    yield Desk(page, *seen_points())
    page.close()
    own = address.split('/?')[0]
    assert [url for url in asked if not url.startswith((own, own.replace('http', 'ws')))] == []


def test_twelve_points_clicked_make_a_grid_within_a_pixel_or_two_of_truth(desk, folder):
    names, page = block(), desk.page
    desk.says('No camera yet')
    for name in names:
        desk.pair(name)
    desk.says('12 points')
    desk.drag(desk.at(IMAGE, *desk.image[names[3]]), right=25, down=6)
    desk.says(f'Point {names[3]} is')
    page.keyboard.press('Control+z')
    desk.is_paired(names[3])
    desk.save('cam1.xml')

    grid = read_grid(folder / 'cam1.xml')
    ground, image = grid.points()
    assert len(ground) == 12
    true = CAMERA.project(np.hstack([ground, np.zeros((12, 1))]))
    assert np.hypot(*(image - true).T).max() < 1.0
    fitted = mapping_from_grid(grid, CAMERA.size)
    assert np.hypot(*(fitted.image_from_ground(ground) - true).T).max() < 1.5


def test_zoomed_to_the_pixel_a_click_is_exact_to_a_tenth(desk, folder):
    names, page = block(2, 2), desk.page
    page.mouse.move(*desk.at(IMAGE, *desk.image[names[0]]))
    for _ in range(12):
        page.mouse.wheel(0, -300)
    page.wait_for_function("document.querySelector('.board svg').viewBox.baseVal.width < 60")
    desk.pair(names[0])
    page.get_by_role('button', name='Whole').click()
    page.wait_for_function("document.querySelector('.board svg').viewBox.baseVal.width > 700")
    for name in names[1:]:
        desk.pair(name)
    desk.save('cam1.xml')
    grid = read_grid(folder / 'cam1.xml')
    clicked = dict(zip(grid.names[0], grid.image[0]))[names[0]]
    assert clicked == pytest.approx(desk.image[names[0]], abs=0.1)


def test_the_place_first_pairs_too_and_delete_takes_it_apart(desk):
    name, page = block()[0], desk.page
    page.mouse.click(*desk.at(IMAGE, *desk.image[name]))
    desk.says('Now click its point on the plan')
    desk.choose(name)
    desk.is_paired(name)
    page.mouse.click(*desk.at(IMAGE, *desk.image[name]))
    desk.says('drag it to mend')
    page.keyboard.press('Delete')
    page.wait_for_selector('.image .mark', state='detached')


def test_without_the_token_nothing_is_shown(browser, address):
    page, own = browser.new_page(), address.split('?')[0]
    page.set_default_timeout(PATIENCE_MS)
    assert page.goto(own).status == 403
    for token in ('a-wrong-one', address.partition('=')[2]):
        page.get_by_label('Token').fill(token)
        page.get_by_role('button', name='Enter').click()
    page.wait_for_selector('.board')
    assert page.url == own
    page.close()
