from mctrack_ros.web.calibrate.assessment import assessed, point_rows
from web.scenes import block, paired


def test_it_says_why_there_is_no_camera_yet():
    found = assessed(paired(block()[:3]))
    assert (found.headline, found.kind) == ('No camera yet', 'open')
    assert '3 points' in found.details[0]


def test_a_good_camera_is_described():
    found = assessed(paired(block()))
    assert found.kind == 'good'
    assert '12 points' in found.headline
    assert '15.0 m high' in ' '.join(found.details)
    assert found.warnings == ()


def test_it_names_points_to_check_and_points_that_are_not_saved():
    names = [*block(), '6-6']
    pairing = paired(names)
    x, y = pairing.pairs[names[4]]
    pairing.move(names[4], x, y + 15)
    found = assessed(pairing)
    assert found.kind == 'bad'
    assert found.warnings[0].startswith(f'Point {names[4]} is 1')
    assert '6-6' in found.warnings[1]


def test_a_row_a_pair_with_its_residual():
    pairing = paired(block()[:1])
    assert point_rows(pairing)[0]['residual'] is None
    rows = point_rows(paired(block()))
    assert [row['name'] for row in rows] == block()
    assert all(row['residual'] < 0.1 for row in rows)
