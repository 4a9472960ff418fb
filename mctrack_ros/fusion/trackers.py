"""The seam of fusion's trackers: what each is, and all of them by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, Protocol, runtime_checkable

from mctrack_ros.config import ConfigError, OneOf
from mctrack_ros.fusion.batcher import Batcher
from mctrack_ros.fusion.belief.config import BeliefConfig
from mctrack_ros.fusion.belief.pipeline import BeliefTracker
from mctrack_ros.fusion.cells.config import CellsConfig
from mctrack_ros.fusion.cells.pipeline import CellTracker
from mctrack_ros.fusion.cells.report import CellReport
from mctrack_ros.fusion.cells.report import unusable_count as unusable_tracks
from mctrack_ros.fusion.config import FusionConfig
from mctrack_ros.fusion.explain.recorder import DecisionRecorder
from mctrack_ros.fusion.inputs import BeliefInput, GridInput, OccupancyInput
from mctrack_ros.fusion.joint_tracker.config import JointConfig
from mctrack_ros.fusion.joint_tracker.output import FusionOutput
from mctrack_ros.fusion.joint_tracker.pipeline import JointTracker
from mctrack_ros.fusion.likelihood_grid.config import LikelihoodGridConfig
from mctrack_ros.fusion.likelihood_grid.pipeline import LikelihoodGridTracker
from mctrack_ros.fusion.measurements.admission import unusable_count
from mctrack_ros.fusion.occupancy.config import OccupancyConfig, VehicleConfig
from mctrack_ros.fusion.occupancy.pipeline import OccupancyTracker
from mctrack_ros.fusion.occupancy.scene import Scene
from mctrack_ros.fusion.occupancy.vehicles import VehicleTracker
from mctrack_ros.fusion.sensor_bias.camera_bias import CameraBias
from mctrack_ros.fusion.views import OpenViews, Views
from mctrack_ros.interfaces import (
    Belief,
    Detections,
    Feedback,
    Foreground,
    Likelihood,
    Message,
    Rows,
    RowsTick,
    Stamped,
    Tracks,
)
from mctrack_ros.interfaces.rows import MOST_WAITING


class FusionTracker(Protocol):
    """All cameras, one tick after another."""

    @property
    def next_id(self) -> int:
        """Id of the next track that begins; ids ascend."""
        ...

    @next_id.setter
    def next_id(self, next_id: int) -> None: ...

    @property
    def bias(self) -> CameraBias | None:
        """How the cameras disagree, in the site's order; None: that is not estimated."""
        ...

    def step(self, tick: RowsTick[Any], recorder: DecisionRecorder | None = None) -> FusionOutput:
        """
        Process one tick; see `JointTracker.step`.

        Its messages are what the tracker's `FusionMethod` makes of those of a camera. The recorder
        is one of `open_recorder`.
        """
        ...

    def feedback(self) -> Rows:
        """Return the feedback after the last tick, stamped with it."""
        ...


@runtime_checkable
class Startable(Protocol):
    """A fusion tracker whose tracks can be started and ended from outside."""

    def start(self, rows: Detections) -> None:
        """
        Start a track where a row is, and end the one whose id a row without position (NaN) has.

        That is done at the first tick from the rows' stamp on.
        """
        ...


START_TOPIC = 'start'
"""Where such a tracker takes that."""

Opener = Callable[[Any, tuple[str, ...], int, OpenViews], FusionTracker]


class FusionMethod(NamedTuple):
    """
    A tracker that fusion can have.

    Attributes
    ----------
    config : type
        Its parameters.
    open : callable
        Makes one of parameters, the cameras' names, the first id and the views; see
        `open_fusion`.
    messages : tuple of type
        What a camera sends to it for every image, each on the topic of its type.
    joined : callable
        Makes one of these messages of one image.
    unusable : callable
        Tells how many rows of that cannot be used.
    feedback : type
        Message type of its feedback, on the topic of that type.
    recorder : callable, optional
        Makes what takes down why a tick is decided as it is; None: this tracker does not say.
    are_stamps_right : bool
        Whether the stamps have been set right already: nothing is added to them.

    """

    config: type[FusionConfig]
    open: Opener
    messages: tuple[type[Message], ...]
    joined: Callable[..., Stamped]
    unusable: Callable[[Any], int]
    feedback: type[Rows] = Feedback
    recorder: Callable[[], DecisionRecorder] | None = None
    are_stamps_right: bool = False


def _open_occupancy(
    config: OccupancyConfig, cameras: tuple[str, ...], first_id: int, views: OpenViews
) -> OccupancyTracker:
    people = config.people
    scene = Scene(views(), cameras, people)
    return OccupancyTracker(config, cameras, first_id, scene, people.person_cost)


TRACKERS: dict[str, FusionMethod] = {
    'joint': FusionMethod(
        JointConfig,
        lambda config, cameras, first_id, _: JointTracker(config, cameras, first_id),
        (Detections,),
        lambda detections: detections,
        unusable_count,
        recorder=DecisionRecorder,
    ),
    'occupancy': FusionMethod(
        OccupancyConfig,
        _open_occupancy,
        (Detections, Foreground),
        OccupancyInput,
        lambda taken: 0,
        recorder=DecisionRecorder,
    ),
    'vehicles': FusionMethod(
        VehicleConfig,
        VehicleTracker,
        (Detections, Foreground),
        OccupancyInput,
        lambda taken: unusable_count(taken.detections),
        recorder=DecisionRecorder,
    ),
    'likelihood_grid': FusionMethod(
        LikelihoodGridConfig,
        LikelihoodGridTracker,
        (Detections, Likelihood, Foreground),
        GridInput,
        lambda taken: 0,
    ),
    'belief': FusionMethod(
        BeliefConfig,
        lambda config, cameras, first_id, _: BeliefTracker(config, cameras, first_id),
        (Detections, Belief),
        BeliefInput,
        lambda taken: 0,
        Belief,
    ),
    'cells': FusionMethod(
        CellsConfig,
        lambda config, cells, first_id, _: CellTracker(config, cells, first_id),
        (Tracks, Feedback),
        CellReport,
        unusable_tracks,
        are_stamps_right=True,
    ),
}
FUSION: OneOf[FusionConfig] = OneOf(
    'tracker',
    'joint',
    'Fusion tracker: joint (from detections), occupancy (people from masks), vehicles (vehicles '
    'from masks, people from detections), likelihood_grid (from edges and masks), belief (from '
    'particles in each view) or cells (from the tracks of other fusion nodes, which `cameras` '
    'names); a site that names none gets the one that suits its calibrations',
    TRACKERS,
)
"""The choice of fusion's tracker, with its parameters."""
COMPILED_ON_DEMAND = (
    'mctrack_ros.fusion.association.solvers.belief',
    'mctrack_ros.fusion.association.solvers.covering_graph',
    'mctrack_ros.fusion.association.solvers.jpda',
    'mctrack_ros.fusion.association.solvers.nearest',
    'mctrack_ros.fusion.belief',
    'mctrack_ros.fusion.motion.imm',
    'mctrack_ros.fusion.occupancy',
    'mctrack_ros.tracking.particles',
)
"""Methods that are not the default: their loops are compiled when they are first called."""


def fusion_method(config: FusionConfig) -> FusionMethod:
    """Return the tracker that parameters are of."""
    return TRACKERS[config.tracker]


def no_views() -> Views:
    """Refuse, by `ConfigError`, a tracker that has to know how cameras see the ground."""
    raise ConfigError('this tracker needs calibrations: name the site YAML')


def open_fusion(
    config: FusionConfig,
    cameras: tuple[str, ...],
    first_id: int = 1,
    views: OpenViews = no_views,
) -> FusionTracker:
    """
    Return the tracker that parameters are of.

    Parameters
    ----------
    config : FusionConfig
        The parameters.
    cameras : tuple of str
        Names in the site's order, at most 32.
    first_id : int
        Id of the first track; those of later ones ascend from it.
    views : callable
        Reads how the cameras see the ground, if the tracker has to know.

    Raises
    ------
    ConfigError, CalibrationError
        If the tracker has to know that, and it is not known.
    ValueError
        If there are too many cameras or a name occurs twice.

    """
    return fusion_method(config).open(config, cameras, first_id, views)


def open_batcher(config: FusionConfig, cameras: tuple[str, ...]) -> Batcher[Any]:
    """Return what sorts the cameras' messages into the ticks of a tracker; see `Batcher`."""
    method = fusion_method(config)
    batcher: Batcher[Any] = Batcher(config, cameras, method.unusable)
    if method.are_stamps_right:
        batcher.ahead_ns = dict.fromkeys(cameras, 0)
    return batcher


def open_recorder(config: FusionConfig) -> DecisionRecorder | None:
    """Return what takes down why the next tick is decided as it is; None: nobody can say."""
    recorder = fusion_method(config).recorder
    return None if recorder is None else recorder()


class Joining:
    """
    Collects what a camera tells of one image on several topics.

    Parameters
    ----------
    config : FusionConfig
        Of the tracker.

    """

    def __init__(self, config: FusionConfig) -> None:
        self._kinds = len(fusion_method(config).messages)
        self._waiting: dict[str, dict[int, dict[str, Message]]] = {}

    def add(self, camera: str, message: Message) -> dict[str, Message] | None:
        """Take a message; return all of its image by topic, once that is complete."""
        images = self._waiting.setdefault(camera, {})
        parts = images.setdefault(message.stamp_ns, {})
        parts[message.TOPIC] = message
        if len(parts) < self._kinds:
            while len(images) > MOST_WAITING:
                del images[next(iter(images))]
            return None
        return images.pop(message.stamp_ns)


def joined(method: FusionMethod, parts: Mapping[str, Message]) -> Stamped:
    """Join all that a camera tells of one image, by topic."""
    return method.joined(*(parts[kind.TOPIC] for kind in method.messages))
