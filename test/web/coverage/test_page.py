"""The coverage page in headless Chromium, by a real mouse."""

import re

import pytest

from mctrack_ros.ground import read_grid
from web.desk import PATIENCE_MS
from web.fields import write_site

ON_SCREEN = """([x, y]) => {
  const place = new DOMPoint(x, -y);
  const seen = place.matrixTransform(document.querySelector('.board svg').getScreenCTM());
  return [seen.x, seen.y];
}"""

pytestmark = [pytest.mark.browser, pytest.mark.xdist_group('browser')]


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp('coverage')
    write_site(path)
    return path


def test_a_field_is_drawn_mended_and_saved(browser, serve, folder):
    with serve(folder, 'coverage', 'two.yaml', '--cell', '2', '--web') as address:
        page = browser.new_page(viewport={'width': 1280, 'height': 760})
        page.set_default_timeout(PATIENCE_MS)
        page.on('pageerror', lambda error: pytest.fail(f'the page fails: {error}'))
        page.goto(address)
        page.wait_for_selector('.board .field')
        corners = [(10, 10), (40, 10), (40, 40), (10, 40)]
        for count, corner in enumerate(corners, 1):
            page.mouse.click(*page.evaluate(ON_SCREEN, corner))
            page.wait_for_function(f"document.querySelectorAll('.mark.corner').length == {count}")
        x, y = page.evaluate(ON_SCREEN, (40, 40))
        to_x, to_y = page.evaluate(ON_SCREEN, (60, 50))
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move((x + to_x) / 2, (y + to_y) / 2)
        page.mouse.move(to_x, to_y)
        page.mouse.up()
        page.get_by_text(re.compile('^13[2-7][0-9]$')).first.wait_for()
        page.get_by_text('fused error').click()
        page.get_by_role('button', name='Save').click()
        page.get_by_text('Saved into the grids of cam1').first.wait_for()
        page.close()
    found = sorted(map(tuple, read_grid(folder / 'cam1.xml').fov.tolist()))
    wanted = sorted([(10, 10), (40, 10), (60, 50), (10, 40)])
    assert len(found) == 4
    assert max(abs(a - b) for one, two in zip(found, wanted) for a, b in zip(one, two)) < 0.3
    assert read_grid(folder / 'cam2.xml').fov is None
