"""How a background model learns from images: one module a rule."""

from mctrack_ros.perception.background.rules.approximate_median import ApproximateMedian
from mctrack_ros.perception.background.rules.buffered_median import BufferedMedian
from mctrack_ros.perception.background.rules.illumination import Light, relit
from mctrack_ros.perception.background.rules.low_pass import LowPassRule, low_pass
from mctrack_ros.perception.background.rules.mixture import Mixture
from mctrack_ros.perception.background.rules.ranks import median_of_nine, smoother
from mctrack_ros.perception.background.rules.rule import BackgroundUpdate, Rule

__all__ = [
    'ApproximateMedian',
    'BackgroundUpdate',
    'BufferedMedian',
    'Light',
    'LowPassRule',
    'Mixture',
    'Rule',
    'low_pass',
    'median_of_nine',
    'relit',
    'smoother',
]
