"""The eight steps of one image, in order (silhouettes paper, section 4)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from mctrack_ros.interfaces import ClassCode, EventCode
from mctrack_ros.perception.background.model import Background
from mctrack_ros.perception.events.event_log import EventLog
from mctrack_ros.perception.geometry.person_size import SizeTable
from mctrack_ros.perception.local_tracks.classification import ClassConfig, looks_like_vehicle
from mctrack_ros.perception.silhouettes.features import (
    HEIGHT,
    WIDTH,
    ComparisonConfig,
    Floats,
    Ints,
    Mask,
    Shapes,
)
from mctrack_ros.perception.silhouettes.foreground.components import Silhouettes
from mctrack_ros.perception.silhouettes.foreground.fragment_merging import (
    FragmentMergingConfig,
    gathered,
    without_crumbs,
)
from mctrack_ros.perception.silhouettes.foreground.hysteresis import with_faint
from mctrack_ros.perception.silhouettes.matching.duplicates import (
    secure_silhouettes,
    settled,
    without_parts,
    without_shrunk,
    without_swollen,
    without_transient_duplicates,
)
from mctrack_ros.perception.silhouettes.matching.joining import join_fragments
from mctrack_ros.perception.silhouettes.matching.macro_object import resolve_merges
from mctrack_ros.perception.silhouettes.matching.match import (
    MatchConfig,
    naive_matches,
    valid_matches,
)
from mctrack_ros.perception.silhouettes.matching.partition import (
    DivisionConfig,
    may_be_several,
    partition_merged,
)
from mctrack_ros.perception.silhouettes.objects import ObjectConfig, ObjectList, at_edge


@dataclass(frozen=True)
class SilhouetteTrackerConfig:
    """Parameters of `SilhouetteTracker`."""

    comparison: ComparisonConfig = field(default_factory=ComparisonConfig)
    match: MatchConfig = field(default_factory=MatchConfig)
    fragment_merging: FragmentMergingConfig = field(default_factory=FragmentMergingConfig)
    division: DivisionConfig = field(default_factory=DivisionConfig)
    objects: ObjectConfig = field(default_factory=ObjectConfig)
    classes: ClassConfig = field(default_factory=ClassConfig)


@dataclass(frozen=True, eq=False, slots=True)
class Assignment:
    """
    What steps 1 to 7 gave.

    Attributes
    ----------
    shapes : Shapes
        Silhouettes after partitions and joins.
    match : (n, m) bool array
        The match matrix: at most one in each row and column.
    origin : (m,) int64 array
        Connected component that each silhouette is, or the first that it was joined of.

    """

    shapes: Shapes
    match: Mask
    origin: Ints


class SilhouetteTracker:
    """
    Matches objects to silhouettes by form, dividing and joining silhouettes as it goes.

    Parameters
    ----------
    config : SilhouetteTrackerConfig
        Parameters.
    sizes : SizeTable
        Of the camera.

    Attributes
    ----------
    objects : ObjectList
        What is tracked.

    """

    def __init__(self, config: SilhouetteTrackerConfig, sizes: SizeTable) -> None:
        self._config, self._sizes = config, sizes
        self._weights = config.comparison.weights()
        self.objects = ObjectList(config.objects)
        self._last_ns: int | None = None

    def restart(self) -> None:
        """Forget all objects; ids go on."""
        self.objects.clear()
        self._last_ns = None

    def step(
        self,
        silhouettes: Silhouettes,
        background: Background,
        stamp_ns: int,
        log: EventLog,
    ) -> Ints:
        """
        Process the silhouettes of one image.

        Parameters
        ----------
        silhouettes : Silhouettes
            Of the image.
        background : Background
            What separates them.
        stamp_ns : int
            Its time, ns.
        log : EventLog
            Takes the exits (E4) of established objects.

        Returns
        -------
        (n,) int64 array
            Connected component that each object shares with another established one; -1: none.

        """
        size = silhouettes.labels.shape
        seconds = self._predict(stamp_ns)
        silhouettes = self._bodies(silhouettes, background)
        found = self._assign(silhouettes, stamp_ns)
        lost = self._update(found, size, stamp_ns, seconds)
        component = self._components(found, size, seconds)
        self._note_exits(lost, size, log)
        self.objects.keep(~lost)
        begun = self._begin(found, stamp_ns)
        return np.asarray(np.r_[component[~lost], np.full(begun, -1)])

    def _predict(self, stamp_ns: int) -> float:
        """Predict the objects; return the time since the last image, s."""
        seconds = 0.0 if self._last_ns is None else (stamp_ns - self._last_ns) * 1e-9
        self._last_ns = stamp_ns
        self.objects.predict(seconds)
        return seconds

    def _update(
        self, found: Assignment, size: tuple[int, ...], stamp_ns: int, seconds: float
    ) -> Mask:
        """Let the objects follow their silhouettes; return which, (n,), are lost."""
        objects = self.objects
        covers = may_be_several(found.shapes, self._sizes, self._config.division)
        lost = objects.update(found.shapes, found.match, covers, stamp_ns, seconds)
        outside = at_edge(objects.box, size, self._config.objects.edge_px)
        return lost | (~objects.matched & outside)

    def _components(self, found: Assignment, size: tuple[int, ...], seconds: float) -> Ints:
        """Return the component, (n,), that objects share; note how long each was alone."""
        objects = self.objects
        component = _shared(found, objects.established)
        whole = objects.matched & (component < 0) & ~at_edge(objects.box, size, 1.0)
        objects.alone_s[whole] += seconds
        return component

    def _begin(self, found: Assignment, stamp_ns: int) -> int:
        """Begin objects of large silhouettes that nobody has; return how many."""
        unclaimed = ~found.match.any(axis=0)
        large = found.shapes.area >= self._config.objects.least_area_px
        fresh = found.shapes.select(unclaimed & large)
        self.objects.start(fresh, stamp_ns)
        return len(fresh)

    def _bodies(self, silhouettes: Silhouettes, background: Background) -> Silhouettes:
        """Gather what belongs to one body; leave out what is too small to be one."""
        sizes, config = self._sizes, self._config.fragment_merging
        is_known = self.objects.established & (self.objects.alone_s >= config.known_s)
        silhouettes = gathered(silhouettes, self.objects.shapes.select(is_known), sizes, config)
        small_px = self._config.objects.least_area_px
        silhouettes = with_faint(silhouettes, background, sizes, config, small_px)
        return without_crumbs(silhouettes, sizes, config)

    def _note_exits(self, lost: Mask, size: tuple[int, ...], log: EventLog) -> None:
        """Note established objects that were lost at the image's edge."""
        left = at_edge(self.objects.box, size, self._config.objects.edge_px)
        for row in np.flatnonzero(lost & left & self.objects.announced).tolist():
            log.add(EventCode.EXIT, self.objects, row)

    def _assign(self, silhouettes: Silhouettes, stamp_ns: int) -> Assignment:
        """Run steps 1 to 7."""
        reach = self._reach(stamp_ns)
        divisible = may_be_several(silhouettes.shapes, self._sizes, self._config.division)
        match = self._matched(silhouettes.shapes, divisible, reach)
        found = self._divided(silhouettes, match, divisible)
        return self._joined(found, reach)

    def _matched(self, shapes: Shapes, divisible: Mask, reach: Floats) -> Mask:
        """Match objects with silhouettes, and decide who is in those of several (steps 1 to 3)."""
        weights, body_s = self._weights, self._config.objects.body_s
        objects, established = self.objects.shapes, self.objects.established
        valid = valid_matches(objects, shapes, self._config.match, reach)
        valid &= ~self._stripes(shapes)
        match = naive_matches(objects, shapes, valid, self._config.match, weights)
        match = without_transient_duplicates(match, established)
        match = resolve_merges(objects, shapes, match, valid, established, weights, divisible)
        match = without_transient_duplicates(match, established)
        match = without_parts(match, established, objects.area, self.objects.alone_s, body_s)
        return self._uncovered(match, shapes) if body_s > 0.0 else match

    def _divided(self, silhouettes: Silhouettes, match: Mask, divisible: Mask) -> Assignment:
        """Divide the silhouettes of several objects among these (steps 4 and 5)."""
        objects, established = self.objects.shapes, self.objects.established
        shapes, match, origin = partition_merged(
            objects,
            silhouettes,
            silhouettes.shapes,
            divisible,
            match,
            established,
            self._config.division,
            self._weights,
        )
        if self._config.objects.body_s > 0.0:
            match = self._of_one_class(match, shapes, silhouettes.labels.shape)
        return Assignment(shapes, settled(objects, shapes, match, self._weights), origin)

    def _joined(self, found: Assignment, reach: Floats) -> Assignment:
        """Join the fragments of one object (steps 6 and 7)."""
        shapes, match, origin = found.shapes, found.match, found.origin
        objects, established = self.objects.shapes, self.objects.established
        for joiners in (established, ~established):
            fragments = ~secure_silhouettes(match, established)
            if not fragments.any():
                break
            valid = valid_matches(objects, shapes, self._config.match, reach)
            shapes, match, kept = join_fragments(
                objects, shapes, match, valid, joiners, fragments, self._weights
            )
            origin = origin[kept]
        return Assignment(shapes, match, origin)

    def _known(self, kind: ClassCode) -> Mask:
        """Tell which objects, (n,), were seen whole and alone and are of a class."""
        known = self.objects.alone_s >= self._config.objects.body_s
        return np.asarray(known & (self.objects.class_id == kind))

    def _stripes(self, shapes: Shapes) -> Mask:
        """Tell which silhouettes, (n, m), are too wide and low to be known pedestrians."""
        config = self._config.match
        known = self._known(ClassCode.PERSON)[:, None] & (config.pedestrian_m > 0.0)
        size, own = shapes.box[None, :, 2:], self.objects.vector[:, None, [WIDTH, HEIGHT]]
        wide = size[..., 0] > config.stripe_width * own[..., 0]
        return np.asarray(known & wide & (size[..., 1] < config.stripe_height * own[..., 1]))

    def _vehicle_like(self, shapes: Shapes) -> Mask:
        extent = shapes.box[:, 2:] / self._sizes.per_metre(self._sizes.foot_of(shapes.box))
        return looks_like_vehicle(extent, self._config.classes)

    def _uncovered(self, match: Mask, shapes: Shapes) -> Mask:
        """Leave silhouettes that vehicles want to them: pedestrians are hidden there."""
        vehicle = self.objects.established & (self.objects.class_id == ClassCode.VEHICLE)
        wanted = match[vehicle].any(axis=0) & self._vehicle_like(shapes)
        return without_swollen(match, self._known(ClassCode.PERSON), wanted)

    def _of_one_class(self, match: Mask, shapes: Shapes, size: tuple[int, ...]) -> Mask:
        """Let no pedestrian become a vehicle, nor a vehicle a pedestrian."""
        match = without_swollen(match, self._known(ClassCode.PERSON), self._vehicle_like(shapes))
        small = ~may_be_several(shapes, self._sizes, self._config.division)
        small &= ~at_edge(shapes.box, size, 1.0)
        return without_shrunk(match, self._known(ClassCode.VEHICLE), small)

    def _reach(self, stamp_ns: int) -> Floats:
        """Return how far, (n,) px, from where they are expected objects are looked for."""
        objects, config = self.objects, self._config.match
        reach = np.full(len(objects), config.radius_px)
        rows = np.flatnonzero(self._known(ClassCode.PERSON))
        if config.pedestrian_m > 0.0 and len(rows):
            foot = self._sizes.foot_of(objects.box[rows])
            unseen_s = (stamp_ns - objects.seen_ns[rows]) * 1e-9
            metres = config.pedestrian_m + config.pedestrian_mps * unseen_s
            reach[rows] = np.fmin(reach[rows], metres * self._sizes.per_metre(foot)[:, 1])
        return reach


def _shared(found: Assignment, rows: Mask) -> Ints:
    """Return, (n,), the component that each of some objects shares with another; -1: none."""
    if not len(found.shapes):
        return np.full(len(rows), -1)
    mine = found.origin[found.match.argmax(axis=1)]
    component = np.where(found.match.any(axis=1) & rows, mine, -1)
    count = np.bincount(component[component >= 0], minlength=len(found.origin) + 1)
    return np.where(count[component] > 1, component, -1)
