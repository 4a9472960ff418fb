import numpy as np
import pytest

from mctrack_ros.interfaces import ClassCode
from mctrack_ros.perception.background.model import Background, BackgroundConfig
from mctrack_ros.perception.silhouettes import as_printed
from mctrack_ros.perception.silhouettes.foreground.components import (
    ComponentConfig,
    find_silhouettes,
)
from mctrack_ros.perception.silhouettes.objects import ObjectConfig, ObjectList
from mctrack_ros.perception.silhouettes.reference_update.absorption import (
    Absorption,
    AbsorptionConfig,
)

PERIOD_NS = 250_000_000
SIZE = (60, 120)
CAR, DRIVER = (40, 20, 40, 24), (80, 18, 6, 18)


class Scene:
    """Boxes on grey ground that a watch looks at, each box an object."""

    def __init__(self, config):
        self.background = Background(BackgroundConfig(minimum_threshold=7.0))
        self.background.begin(np.full((*SIZE, 3), 100, np.uint8))
        self.watch = Absorption(config)
        self.index = 0
        self.objects = ObjectList(ObjectConfig())

    def show(self, *things):
        self.index += 1
        stamp_ns = self.index * PERIOD_NS
        self.grey = np.full(SIZE, 100, np.uint8)
        for (left, top, width, height), value, _ in things:
            self.grey[top : top + height, left : left + width] = value
        model = self.background.model[..., 0].astype(int)
        mask = np.where(np.abs(self.grey - model) > 7, 255, 0).astype(np.uint8)
        image = np.repeat(self.grey[..., None], 3, axis=2)
        self.watch.watch(self.background, image, mask, stamp_ns)
        found = find_silhouettes(mask, self.grey, ComponentConfig(1, 1))
        self._follow(found.shapes, [kind for *_, kind in things], stamp_ns)
        return self.watch.insert_resting(
            self.objects, self.background, image, mask, found.labels, stamp_ns
        )

    def _follow(self, shapes, kinds, stamp_ns):
        same = len(shapes) == len(self.objects)
        if not same:
            self.objects.clear()
            self.objects.start(shapes, stamp_ns)
        self.objects.vector[:], self.objects.box[:] = shapes.vector, shapes.box
        self.objects.class_id[:] = (kinds + [ClassCode.VEHICLE] * len(shapes))[: len(shapes)]
        self.objects.travelled_px[:] = 50.0


@pytest.fixture(params=['by pixels', 'as printed'])
def scene(request):
    return Scene(AbsorptionConfig() if request.param == 'by pixels' else as_printed().absorption)


def rest_of(scene, *things, seconds):
    return [bool(scene.show(*things).any()) for _ in range(round(seconds * 4))]


def test_a_vehicle_is_background_after_four_seconds(scene):
    gone = rest_of(scene, (CAR, 60, ClassCode.VEHICLE), seconds=5)

    assert 16 <= gone.index(True) <= 18
    assert (scene.background.model[20:44, 40:80] == 60).all()
    assert [entry.local_id for entry in scene.watch.inserted] == [1]


def test_a_pedestrian_is_not_so_soon():
    scene = Scene(AbsorptionConfig())

    assert not any(rest_of(scene, (DRIVER, 60, ClassCode.PERSON), seconds=9))


def test_whoever_stands_for_long_is_background():
    scene = Scene(AbsorptionConfig())

    assert any(rest_of(scene, (DRIVER, 60, ClassCode.PERSON), seconds=14))


def test_a_vehicle_that_moves_is_not(scene):
    gone = []
    for step in range(40):
        box = (step, *CAR[1:])
        gone += rest_of(scene, (box, 60 + step % 2 * 9, ClassCode.VEHICLE), seconds=0.25)

    assert not any(gone)


def test_somebody_who_gets_out_neither_delays_it_nor_stays_in_the_background():
    scene, gone = Scene(AbsorptionConfig()), []
    for step in range(22):
        driver = (82 - step, 26, 6, 18)  # in one silhouette with the car
        gone.append(
            scene.show((CAR, 60, ClassCode.VEHICLE), (driver, 140, ClassCode.PERSON)).any()
        )

    assert any(gone)
    assert not (scene.background.model == 140).any()


def test_a_vehicle_that_leaves_leaves_no_hole():
    scene = Scene(AbsorptionConfig())
    rest_of(scene, (CAR, 60, ClassCode.VEHICLE), seconds=5)

    for step in range(8):
        scene.show(((40 + 5 * step, *CAR[1:]), 60, ClassCode.VEHICLE))

    assert scene.watch.inserted == []
    assert (scene.background.model == 100).all()


def test_the_hole_of_an_inserted_vehicle_is_patched_as_printed():
    scene = Scene(as_printed().absorption)
    rest_of(scene, (CAR, 60, ClassCode.VEHICLE), seconds=5)

    gone = rest_of(scene, seconds=1.5)

    assert gone.index(True) <= 3
    assert (scene.background.model == 100).all()
    assert scene.watch.inserted == []
