"""What changes before a camera and is nobody: furniture, light, exposure, the camera itself."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import cv2
import numpy as np
import yaml
from numpy.typing import NDArray

from mctrack_experiments.bench.workers import Progress, silent
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.fusion import fusion_method, joined
from mctrack_ros.ground import ProjectiveMapping
from mctrack_ros.interfaces import REPORTED, CameraRows, RowsTick, Tracks
from mctrack_ros.perception import open_buffer
from mctrack_ros.replay.drive import drive
from mctrack_ros.replay.lockstep import tick_ns
from mctrack_ros.site.choice import with_tracker
from mctrack_ros.site.site import SiteConfig, load_site

Image = NDArray[np.uint8]
Floats = NDArray[np.float64]
SIZE, FOCAL = (320, 240), 300.0
RATE_HZ = 12.5
PERIOD_NS = round(1e9 / RATE_HZ)
START_NS = 1_700_000_000_000_000_000
VIEWS = {'north': (1.0, 11.0, 4.2), 'south': (-3.0, -10.0, 3.6)}
FLOOR_M, FLOOR_PX_PER_M, FINER = 40.0, 40.0, 4
NOISE, QUALITY = 2.5, 85
GATE_M = 1.0
CHAIR, DOOR = (0.95, 0.5), (2.2, 2.4)
COLOURS = (
    ((40, 40, 170), (60, 50, 40)),
    ((170, 90, 40), (40, 40, 45)),
    ((60, 160, 170), (90, 70, 50)),
)
"""Blue, green, red of people's upper and lower halves."""


def nothing(_: float) -> float:
    """Return that a camera is not turned."""
    return 0.0


def day(_: float) -> Floats:
    """Return the factors of blue, green and red of a day without change."""
    return np.ones(3)


@dataclass(frozen=True)
class ChangingView:
    """
    A scene of people on a textured floor that two cameras see.

    Attributes
    ----------
    seconds : float
        How long it is, s.
    people : callable
        Where people are at a time: by number, (2,) m.
    thing : callable
        Where the lower end of a thing is at a time, (3,) m; None: nowhere.
    thing_m : tuple of float
        Height and width of the thing, a chair unless given, m.
    turn_deg : callable
        By how much the first camera is turned about the upright at a time, degrees.
    light : callable
        Factors of blue, green and red at a time, (3,).
    lamp_s : float
        When a lamp goes on that lights a part of the floor, s.
    after_s : float
        What counts from when on, s.

    """

    seconds: float
    people: Callable[[float], dict[int, Floats]]
    thing: Callable[[float], Floats | None] = field(default=lambda _: None)
    thing_m: tuple[float, float] = CHAIR
    turn_deg: Callable[[float], float] = nothing
    light: Callable[[float], Floats] = day
    lamp_s: float = np.inf
    after_s: float = 2.0


def along(places: list[tuple[float, float, float]]) -> Callable[[float], Floats | None]:
    """Return where somebody is who walks from place to place: (time, x, y), s and m."""
    time, x, y = np.array(places).T

    def place(seconds: float) -> Floats | None:
        if not time[0] <= seconds <= time[-1]:
            return None
        return np.array([np.interp(seconds, time, x), np.interp(seconds, time, y)])

    return place


def walkers(*paths: list[tuple[float, float, float]]) -> Callable[[float], dict[int, Floats]]:
    """Return who is where, of several who walk from place to place."""
    places = [along(path) for path in paths]

    def people(seconds: float) -> dict[int, Floats]:
        there = {index: place(seconds) for index, place in enumerate(places)}
        return {index: where for index, where in there.items() if where is not None}

    return people


def strolling(
    number: int, begin_s: float, end_s: float, away: bool = True
) -> list[tuple[float, float, float]]:
    """Return the path of somebody who comes in, walks to and fro and, if so, leaves again."""
    side = (-1) ** number
    row = 1.6 * number - 1.6
    path = [(begin_s, 9.0 * side, row)] if away else []
    time, x = (begin_s + 6.0, 2.5 * side) if away else (begin_s, 2.5 * side)
    while time < end_s - 6.0 * away:
        path.append((time, x, row))
        time, x = time + 4.0, -x
    return [*path, (end_s, 9.0 * side if away else x, row)]


def _furniture() -> ChangingView:
    """Let somebody carry a chair in, put it down and walk on, while another one stands."""
    bearer = [
        (2.0, -9.0, 0.0),
        (8.0, -1.0, 0.0),
        (9.0, -1.0, 0.0),
        (13.0, 4.5, 1.0),
        (45.0, 4.5, 1.2),
    ]
    standing = [(2.0, 9.0, -2.5), (8.0, 1.5, -2.5), (45.0, 1.5, -2.5)]
    carried = along(bearer)

    def chair(seconds: float) -> Floats | None:
        if seconds < 2.0:
            return None
        if seconds < 8.5:
            place = carried(seconds)
            assert place is not None
            return np.array([place[0] + 0.35, place[1], 0.3])
        return np.array([-0.65, 0.0, 0.0])

    return ChangingView(45.0, walkers(bearer, standing), thing=chair)


def _door() -> ChangingView:
    """Let a sliding door open and close five times beside people who walk by."""
    paths = [strolling(number, 2.0, 40.0) for number in range(1, 3)]

    def panel(seconds: float) -> Floats:
        """Return where it is: 1.8 m to the side within .7 s, and back after 3 s."""
        since_s = (seconds - 8.0) % 6.0 if seconds >= 8.0 else 6.0
        is_open = np.interp(since_s, [0.0, 0.7, 3.7, 4.4], [0.0, 1.0, 1.0, 0.0])
        return np.array([-3.0 - 1.8 * is_open, -2.5, 0.0])

    return ChangingView(40.0, walkers(*paths), thing=panel, thing_m=DOOR)


def _bump() -> ChangingView:
    """Turn a camera by 1.5 degrees at 12 s."""
    paths = [strolling(number, 2.0, 25.0) for number in range(3)]
    return ChangingView(25.0, walkers(*paths), turn_deg=lambda at: 1.5 * (at >= 12.0))


def _exposure() -> ChangingView:
    """Let exposure and white balance drift by up to .45 within a minute."""
    paths = [strolling(number, 2.0, 60.0) for number in range(3)]
    swing = np.array([0.45, 0.35, 0.25])
    return ChangingView(
        60.0,
        walkers(*paths),
        light=lambda at: np.asarray(1.0 - swing * np.sin(np.pi * at / 60) ** 2),
    )


def _night() -> ChangingView:
    """Put the lights out at 12 s, and a lamp on."""
    paths = [strolling(number, 2.0, 25.0) for number in range(3)]
    dark = np.array([0.4, 0.33, 0.3])
    return ChangingView(
        25.0, walkers(*paths), light=lambda at: dark if at >= 12.0 else np.ones(3), lamp_s=12.0
    )


def _start() -> ChangingView:
    """Let people be there from the first image on: two walk, one stands for 8 s at first."""
    paths = [strolling(number, 0.0, 25.0, away=False) for number in range(2)]
    waits = [(0.0, 0.5, 2.5), (8.0, 0.5, 2.5), (12.0, -4.0, 2.5), (25.0, 3.0, 2.5)]
    return ChangingView(25.0, walkers(*paths, waits), after_s=3.0)


def _jitter() -> ChangingView:
    """Shake a camera by up to 0.3 degrees, as wind does."""
    paths = [strolling(number, 2.0, 25.0) for number in range(3)]
    return ChangingView(
        25.0, walkers(*paths), turn_deg=lambda at: 0.3 * np.sin(7.0 * at) * np.sin(1.3 * at)
    )


def _standing() -> ChangingView:
    """Let somebody walk in, stand for three minutes and leave, while others walk by."""
    stands = [(2.0, 9.0, -2.5), (8.0, 1.5, -2.5), (188.0, 1.5, -2.5), (196.0, -9.0, -2.5)]
    others = [strolling(number, 4.0, end_s) for number, end_s in enumerate((40.0, 150.0))]
    return ChangingView(200.0, walkers(stands, *others))


SCENES: dict[str, Callable[[], ChangingView]] = {
    'furniture': _furniture,
    'door': _door,
    'bump': _bump,
    'exposure': _exposure,
    'night': _night,
    'start': _start,
    'jitter': _jitter,
    'standing': _standing,
}


def projection(position: tuple[float, float, float], turn_deg: float = 0.0) -> Floats:
    """Return the (3, 4) matrix of a camera that looks at the middle of the floor."""
    centre = np.asarray(position)
    forward = -centre / np.linalg.norm(centre)
    angle = np.radians(turn_deg)
    cos, sin = np.cos(angle), np.sin(angle)
    forward = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]]) @ forward
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    rotation = np.stack([right, np.cross(forward, right), forward])
    intrinsics = np.array([[FOCAL, 0, SIZE[0] / 2], [0, FOCAL, SIZE[1] / 2], [0, 0, 1]])
    return np.asarray(intrinsics @ np.column_stack([rotation, -rotation @ centre]))


class Renderer:
    """Draws a scene as one of its cameras sees it."""

    def __init__(self, scene: ChangingView, camera: str, seed: int) -> None:
        self._scene, self._camera = scene, camera
        self._rng = np.random.default_rng([seed, list(VIEWS).index(camera)])
        self._floor = _floor(seed)
        self._still: dict[float, Image] = {}

    def image(self, seconds: float) -> Image:
        """Return the (h, w, 3) image of a time."""
        scene = self._scene
        turn = float(scene.turn_deg(seconds)) if self._camera == next(iter(VIEWS)) else 0.0
        matrix = projection(VIEWS[self._camera], turn)
        drawn = self._empty(turn, matrix).copy()
        things = [(place, None) for place in [scene.thing(seconds)] if place is not None]
        bodies = [(np.append(place, 0.0), index) for index, place in scene.people(seconds).items()]
        depth = lambda one: -float(matrix[2] @ np.append(one[0], 1.0))  # noqa: E731
        for place, number in sorted([*things, *bodies], key=depth):
            if number is None:
                self._box(drawn, matrix, place, scene.thing_m, (50, 80, 110))
            else:
                self._person(drawn, matrix, place, number, seconds)
        lit = drawn * scene.light(seconds)
        if seconds >= scene.lamp_s:
            y, x = np.mgrid[: SIZE[1], : SIZE[0]]
            spot = np.exp(-(((x - 90) / 70) ** 2 + ((y - 120) / 60) ** 2))
            lit = lit * (1 + 1.2 * spot[..., None])
        noisy = lit + self._rng.normal(0, NOISE, lit.shape)
        return np.clip(np.rint(noisy), 0, 255).astype(np.uint8)

    def _empty(self, turn: float, matrix: Floats) -> Image:
        if turn not in self._still:
            scale = np.diag([1 / FLOOR_PX_PER_M, 1 / FLOOR_PX_PER_M, 1.0])
            scale[:2, 2] = -FLOOR_M / 2
            finer = np.diag([FINER, FINER, 1.0]) @ matrix[:, [0, 1, 3]] @ scale
            size = (FINER * SIZE[0], FINER * SIZE[1])
            floor = cv2.warpPerspective(self._floor, finer, size, borderMode=cv2.BORDER_REFLECT)
            floor = cv2.resize(floor, SIZE, interpolation=cv2.INTER_AREA)
            if len(self._still) > 8:
                self._still.clear()
            self._still[turn] = np.asarray(floor, np.uint8)
        return self._still[turn]

    def _person(self, image: Image, matrix: Floats, place: Floats, number: int, at: float) -> None:
        """Draw a person who sways: legs, upper half, head."""
        upper, lower = COLOURS[number % len(COLOURS)]
        sway = 0.03 * np.sin(1.7 * at + 2 * number)
        stride = 0.12 * np.sin(6.0 * at + number)
        for side in (-1, 1):
            foot = np.add(place, [side * (0.1 + stride), 0, 0])
            self._box(image, matrix, foot, (0.85, 0.17), lower)
        self._box(image, matrix, np.add(place, [sway, 0, 0.8]), (0.7, 0.48), upper)
        self._box(image, matrix, np.add(place, [sway, 0, 1.5]), (0.25, 0.2), (120, 150, 190))

    def _box(
        self,
        image: Image,
        matrix: Floats,
        place: Floats,
        size: tuple[float, float],
        colour: tuple[int, int, int],
    ) -> None:
        """Draw an upright rectangle of a height and width, m, that faces the camera."""
        low, high = (matrix @ np.append(np.add(place, [0, 0, up]), 1.0) for up in (0.0, size[0]))
        half = FOCAL * size[1] / 2 / low[2]
        corners = (
            [low[0] / low[2] - half, high[1] / high[2]],
            [low[0] / low[2] + half, low[1] / low[2]],
        )
        first, second = (
            tuple(np.rint(np.array(one) * 16).astype(int).tolist()) for one in corners
        )
        cv2.rectangle(image, first, second, colour, -1, cv2.LINE_AA, 4)


def _floor(seed: int) -> Image:
    """Return a floor of grey tiles, each a little different, with grain and joints."""
    rng, side, tile = np.random.default_rng(seed), round(FLOOR_M * FLOOR_PX_PER_M), 24
    level = rng.normal(115, 10, (side // tile, side // tile, 1))
    tiles = (level + rng.normal(0, 3, (*level.shape[:2], 3))).astype(np.float32)
    floor = cv2.resize(tiles, (side, side), interpolation=cv2.INTER_NEAREST)
    floor[::tile] -= 30
    floor[:, ::tile] -= 30
    grain = rng.normal(0, 8, (side, side, 1))
    return np.clip(floor + grain, 0, 255).astype(np.uint8)


def tracked(scene: ChangingView, seed: int = 0) -> Iterator[Tracks]:
    """Track a scene as live cameras do, with what everybody has to say of cameras, by default."""
    with TemporaryDirectory(prefix='mctrack_views_') as name:
        site, _ = with_tracker(_site(Path(name)))
        cameras = {camera: settings.open(camera) for camera, settings in site.cameras.items()}
    renderers = {camera: Renderer(scene, camera, seed) for camera in VIEWS}
    period_ns, delay_ns = tick_ns(site)
    method = fusion_method(site.fusion)
    buffers = {
        camera: open_buffer(settings.pipeline, period_ns, delay_ns)
        for camera, settings in site.cameras.items()
    }

    def ticks() -> Iterator[RowsTick[Any]]:
        for index in range(round(scene.seconds * RATE_HZ)):
            stamp_ns, rows = START_NS + index * PERIOD_NS + PERIOD_NS // 2, []
            for camera, tracker in cameras.items():
                image = renderers[camera].image(index / RATE_HZ)
                compressed = cv2.imencode('.jpg', image, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])[1]
                image = np.asarray(cv2.imdecode(compressed, cv2.IMREAD_COLOR), np.uint8)
                feedback, _ = buffers[camera].select(stamp_ns)
                output = tracker.step(image, stamp_ns, feedback)
                rows.append(CameraRows(camera, joined(method, output.messages)))
            yield RowsTick.of(rows)

    for ticked in drive(site.fusion, site.camera_names, ticks(), views=site.views):
        for buffer in buffers.values():
            buffer.push(ticked.feedback)
        yield ticked.output.tracks


def _site(folder: Path) -> SiteConfig:
    cameras = {}
    for camera, position in VIEWS.items():
        (folder / f'{camera}.yaml').write_text(
            f'image_from_world: {projection(position).tolist()}'
        )
        size = {'image_width': SIZE[0], 'image_height': SIZE[1]}
        cameras[camera] = {'calibration': f'{camera}.yaml'} | size
    content = {
        'name': 'room',
        'cameras': cameras,
        'feedback_delay': 2 / RATE_HZ,
        'fusion': {'batching': {'period': 1 / RATE_HZ}},
    }
    (folder / 'site.yaml').write_text(yaml.safe_dump(content))
    return load_site(folder / 'site.yaml')


def score(scene: ChangingView, instants: Iterable[Tracks]) -> dict[str, float]:
    """
    Compare tracks with where people are.

    Returns
    -------
    dict
        ``most_false``: most tracks at once that are nobody; ``false_s``: time with any, s;
        ``longest_miss_s``: longest time that somebody who was found, and is in view, is not, s;
        ``found``: people; ``ids``: their ids, one each is right.

    """
    views = [ProjectiveMapping(projection(position), SIZE) for position in VIEWS.values()]
    most, false, longest = 0, 0, 0
    missed: dict[int, int] = {}
    ids: dict[int, set[int]] = {}
    for index, tracks in enumerate(instants):
        at = index / RATE_HZ
        shown = tracks.select(np.isin(tracks.status, REPORTED))
        people = scene.people(at)
        places = np.array(list(people.values())).reshape(-1, 2)
        distance = np.linalg.norm(shown.position[:, None, :2] - places[None], axis=2)
        if at >= scene.after_s:
            wrong = int((distance.min(axis=1, initial=np.inf) > GATE_M).sum())
            most, false = max(most, wrong), false + (wrong > 0)
        for column, (person, place) in enumerate(people.items()):
            near = distance[:, column]
            if len(near) and near.min() <= GATE_M:
                ids.setdefault(person, set()).add(int(shown.track_id[near.argmin()]))
                missed[person] = 0
            elif person in missed and at >= scene.after_s and _is_seen(views, place):
                missed[person] += 1
                longest = max(longest, missed[person])
    return {
        'most_false': most,
        'false_s': false / RATE_HZ,
        'longest_miss_s': longest / RATE_HZ,
        'found': len(ids),
        'ids': sum(map(len, ids.values())),
    }


def _is_seen(views: list[ProjectiveMapping], place: Floats) -> bool:
    """Tell whether somebody stands well within an image."""
    for view in views:
        x, y = view.image_from_ground(place[None])[0]
        if 15 < x < SIZE[0] - 15 and 40 < y < SIZE[1] - 5:
            return True
    return False


def reproduce_views(seeds: Sequence[int], progress: Progress = silent) -> Figures:
    """
    Track all scenes, each on several floors with other noise.

    Parameters
    ----------
    seeds : sequence of int
        One floor each.
    progress : callable
        Told how many are done, of how many.

    """
    total = len(SCENES) * len(seeds)
    figures: dict[str, float] = {}
    for done, (name, scene) in enumerate(SCENES.items()):
        scores = []
        for index, seed in enumerate(seeds):
            progress(done * len(seeds) + index, total)
            scores.append(score(scene(), tracked(scene(), seed)))
        for figure in scores[0]:
            figures[f'{name}.{figure}'] = max(each[figure] for each in scores)
    progress(total, total)
    protocol = {
        'scenes': f'two cameras, {SIZE[0]} x {SIZE[1]} px, {RATE_HZ:g} images a second, tiles, '
        'noise and JPEG; two or three people; as live cameras see it, all by default',
        'seeds': ', '.join(map(str, seeds)),
        'figures': 'the worst of all seeds',
        **{name: (scene.__doc__ or '').strip() for name, scene in SCENES.items()},
        'false': f'farther than {GATE_M:g} m from everybody',
    }
    return Figures('views', 'mctrack reproduce views', protocol, figures)
