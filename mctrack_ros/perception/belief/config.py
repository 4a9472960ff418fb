"""Parameters of a view in belief propagation."""

from __future__ import annotations

from dataclasses import dataclass

from mctrack_ros.config import parameter, tag
from mctrack_ros.perception.background.model import BackgroundConfig
from mctrack_ros.perception.camera_shift.monitor import CameraShiftConfig
from mctrack_ros.perception.config import CameraConfig

LIKELIHOODS = ('odds', 'histograms')


@dataclass(frozen=True)
class BeliefCameraConfig(CameraConfig):
    """Parameters of `BeliefCamera`."""

    local_tracker: str = tag('belief')
    likelihood: str = parameter(
        'odds',
        "how boxes are compared with targets: odds, their pixels' against the surroundings; "
        "histograms, by the Bhattacharyya distance, the paper's",
        choices=LIKELIHOODS,
    )
    colour_weight: float = parameter(
        12.0,
        'log-likelihood of a box that looks like the target, over that of the background; of '
        'histograms lambda of exp(-lambda D^2), where 20 is better; 0: images are not looked at',
        minimum=0.0,
        maximum=1000.0,
    )
    moving: bool = parameter(
        False,
        'the camera pans, tilts and zooms: its calibration is that of the first image and is '
        'followed by features and painted lines; it detects nobody, so targets are started by '
        'others',
    )
    prior_density: bool = parameter(
        False, "send the density of predictions, which fusion's printed weights need"
    )
    seed: int = parameter(1, 'seed of the random numbers', minimum=0)
    background: BackgroundConfig = BackgroundConfig()
    camera_shift: CameraShiftConfig = CameraShiftConfig()

    @property
    def moves(self) -> bool:
        """Whether the camera pans, tilts and zooms."""
        return self.moving
