import numpy as np
import pytest

from mctrack_ros.interfaces import Feedback
from mctrack_ros.perception.feedback.buffer import is_sound

TARGET = {
    'position': [[1.0, 2.0, 0.0]],
    'velocity': [[1.0, -1.0]],
    'covariance': [np.diag([0.01, 0.01, 1.0, 1.0])],
    'extent': [[0.5, 1.8]],
    'template': [np.full(48, 1 / 16)],
    'track_id': [7],
}
CROSSED = np.diag([0.01, 0.01, 1.0, 1.0])
CROSSED[0, 2] = CROSSED[2, 0] = 3.0


def test_what_can_be_a_target_is_sound():
    assert is_sound(Feedback.build(0, **TARGET)).tolist() == [True]
    unknown = TARGET | {'extent': [[np.nan, np.nan]], 'template': [np.zeros(48)]}
    assert is_sound(Feedback.build(0, **unknown)).tolist() == [True]
    assert is_sound(Feedback.build(0)).tolist() == []


@pytest.mark.parametrize(
    ('column', 'value'),
    [
        ('position', [3e38, 0.0, 0.0]),
        ('position', [np.nan, 0.0, 0.0]),
        ('velocity', [0.0, -1e9]),
        ('covariance', np.zeros((4, 4))),
        ('covariance', -np.eye(4)),
        ('covariance', np.full((4, 4), 1e30)),
        ('covariance', CROSSED),
        ('extent', [0.0, 1.8]),
        ('extent', [0.5, 1e30]),
        ('template', np.full(48, -1.0)),
        ('template', np.full(48, 1e30)),
    ],
)
def test_what_cannot_is_not(column, value):
    assert is_sound(Feedback.build(0, **(TARGET | {column: [value]}))).tolist() == [False]
