import numpy as np

from mctrack_ros.interfaces import NO_CAMERA, EventCode
from mctrack_ros.simulation import EventWatcher, Sight

PLACE = np.array([20.0, 30.0])


def happened(world, camera_index=0):
    """Return (step, event, true id, the others' ids) of all events of a camera."""
    sight, watcher = Sight(world, camera_index), EventWatcher(world, camera_index)
    rows = []
    for step in range(world.scenario.steps):
        events = watcher.step(step, sight.view(step))
        assert events.stamp_ns == world.scenario.stamp_ns(step)
        for row in range(len(events)):
            others = events.others[row][events.others[row] > 0].tolist()
            assert events.camera[row] == camera_index != NO_CAMERA
            rows.append((step, EventCode(events.event[row]), int(events.track_id[row]), others))
    return rows


def passing(world, steps=100, half=2.0):
    """Return a path that crosses PLACE's line of sight in camera 0, a little behind it."""
    away = PLACE - world.cameras[0].position[:2]
    away /= np.linalg.norm(away)
    across = np.array([-away[1], away[0]])
    return PLACE + 0.8 * away + np.linspace(-half, half, steps)[:, None] * across


def test_a_passer_by_merges_and_splits_once(staged):
    path = passing(staged({}))
    rows = happened(staged({3: PLACE, 4: path}))
    assert [(event, person) for _, event, person, _ in rows[:2]] == [
        (EventCode.NEW, 4),
        (EventCode.NEW, 5),
    ]
    (merge, *merged), (split, *parted) = rows[2:]
    assert merged == [EventCode.MERGE, 5, [4]]
    assert parted == [EventCode.SPLIT, 5, [4]]
    assert 25 < merge < 50 < split < 90


def test_a_merge_is_told_when_silhouettes_first_touch(staged):
    world = staged({3: PLACE, 4: passing(staged({}))})
    sight = Sight(world, 0)
    first = next(s for s in range(world.scenario.steps) if len(sight.view(s).touching))
    assert [step for step, event, *_ in happened(world) if event == EventCode.MERGE] == [first]


def test_a_third_who_joins_two_is_one_merge(staged):
    still = passing(staged({}))[50]
    rows = happened(staged({3: PLACE, 4: still, 5: passing(staged({}), half=3.0)}))
    merges = [row for row in rows if row[1] == EventCode.MERGE and row[0] > 0]
    assert [row[2:] for row in merges] == [(6, [4, 5])]


def test_leaving_the_image_is_an_exit_and_coming_back_an_entry(staged):
    camera = staged({}).cameras[0]
    out = np.linspace(20, -40, 25)
    columns = np.concatenate([out, out[::-1]])
    path = camera.ground(np.column_stack([columns, np.full(50, 300.0)]))
    rows = happened(staged({3: path}))
    assert [row[1] for row in rows] == [EventCode.NEW, EventCode.EXIT, EventCode.ENTER]


def test_whom_another_camera_saw_first_enters(staged):
    world = staged({})
    columns = np.linspace(-40, 20, 25)
    path = world.cameras[0].ground(np.column_stack([columns, np.full(25, 300.0)]))
    seen_elsewhere = happened(staged({3: path}))
    assert world.cameras[1].sees([*path[0], 0.0])
    assert [row[1] for row in seen_elsewhere] == [EventCode.ENTER]
