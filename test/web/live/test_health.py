from types import SimpleNamespace

from mctrack_ros.web.live.health import SILENT_S, Health


def status(name, hardware, level=0, message='', **values):
    return SimpleNamespace(
        name=name, hardware=hardware, level=level, message=message, values=values
    )


def levels(health, now_s):
    return {part['name']: part['level'] for part in health.report(now_s)}


def test_the_worst_of_a_camera_counts_and_others_are_the_trackers():
    health = Health(['cam1', 'cam2'])
    assert set(levels(health, 0.0).values()) == {'waiting'}
    health.hear(
        [
            status('/hall/fusion: cam1', '/hall/cam1', **{'rate [Hz]': '25.0'}),
            status('/hall/cam1_camera: pose', '/hall/cam1', 1, 'the camera has moved'),
            status('/hall/fusion: cam2', '/hall/cam2', 3, 'no data'),
            status('/hall/fusion: exceptions', '/hall/fusion'),
        ],
        10.0,
    )
    cam1, cam2, tracker = health.report(11.0)
    assert (cam1['level'], cam1['text']) == ('warning', 'pose: the camera has moved')
    assert cam1['rate'] == '25.0'
    assert (cam2['level'], cam2['text']) == ('error', 'cam2: no data')
    assert tracker['level'] == 'good'


def test_who_says_nothing_any_more_is_silent():
    health = Health(['cam1'])
    health.hear([status('/cam1_camera: images', '/cam1')], 10.0)
    assert levels(health, 10.0 + SILENT_S)['cam1'] == 'good'
    assert levels(health, 10.1 + SILENT_S)['cam1'] == 'silent'
