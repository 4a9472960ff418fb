"""A camera without tracks of its own tells what happens to the targets that fusion knows."""

import numpy as np

from mctrack_ros.interfaces import EventCode, Feedback
from mctrack_ros.perception.likelihood_grid.config import GridConfig, LikelihoodCameraConfig
from mctrack_ros.perception.likelihood_grid.pipeline import LikelihoodCamera
from perception.conftest import PERIOD_NS, Stage

RED, BLUE = (30, 30, 220), (220, 60, 30)
GRID = GridConfig(area='-8,-4,8,4', cells=20, person_width=0.6)


class Film:
    """People whom fusion knows walk in front of a camera."""

    def __init__(self, mapping, foreground=True):
        self.stage = Stage(mapping)
        config = LikelihoodCameraConfig(grid=GRID, foreground=foreground)
        self.stage.pipeline = LikelihoodCamera(config, mapping)
        self.stage.empty(2.0)
        self.told = []

    def show(self, known, drawn=None):
        """Show an image of those whom fusion knows, or of others; keep the events."""

        def feedback(stamp_ns):
            return Feedback.build(
                stamp_ns - PERIOD_NS,
                position=[[*place, 0.0] for place, _ in known.values()],
                covariance=[np.eye(4) * 0.01] * len(known),
                track_id=list(known),
            )

        people = list(known.values()) if drawn is None else drawn
        events = self.stage.show(people, feedback).events
        for code, who, others in zip(events.event, events.track_id, events.other_tracks):
            everybody = {int(one) for one in (who, *others) if one}
            self.told.append((EventCode(code), everybody))


def crossing(film, steps=80):
    """Two people cross, one close behind the other."""
    for step in range(steps):
        film.show({7: ((-3 + 0.075 * step, 0.0), RED), 8: ((3 - 0.075 * step, 0.6), BLUE)})
    return film.told


def test_two_who_cross_enter_are_stable_merge_part_and_are_stable_again(mapping):
    told = crossing(Film(mapping))
    codes = [code for code, _ in told]
    assert sorted(codes[:4]) == [EventCode.ENTER] * 2 + [EventCode.STABLE] * 2
    assert codes[4:6] == [EventCode.MERGE, EventCode.SPLIT]
    assert told[4][1] == told[5][1] == {7, 8}
    assert codes[6:] == [EventCode.STABLE] * 2


def test_one_told_of_later_is_new_and_who_walks_out_leaves(mapping):
    film = Film(mapping)
    for _ in range(30):
        film.show({7: ((-2.0, 1.0), RED)})
    for _ in range(30):
        film.show({7: ((-2.0, 1.0), RED), 8: ((2.0, 1.0), BLUE)})
    for step in range(60):
        film.show({7: ((-2.0 - 0.15 * step, 1.0), RED), 8: ((2.0, 1.0), BLUE)})
    told = [one for one in film.told if one[0] != EventCode.STABLE]
    assert told == [(EventCode.ENTER, {7}), (EventCode.NEW, {8}), (EventCode.EXIT, {7})]


def test_of_whom_fusion_makes_no_target_nothing_is_told(mapping):
    film = Film(mapping)
    for _ in range(30):
        film.show({}, [((1.0, 1.0), RED)])
    assert film.told == []


def test_who_is_predicted_where_nothing_moves_neither_enters_nor_is_stable(mapping):
    film = Film(mapping)
    for _ in range(30):
        film.show({7: ((-2.0, 1.0), RED)}, [])
    assert film.told == []


def test_by_edges_alone_nothing_is_told(mapping):
    assert crossing(Film(mapping, foreground=False)) == []
