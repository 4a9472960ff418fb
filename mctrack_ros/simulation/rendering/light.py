"""How bright a scene is, and what the camera makes of it, from step to step."""

from __future__ import annotations

import numpy as np

from mctrack_ros.simulation.scenario import Scenario


def brightness(scenario: Scenario, step: int, drift_s: float) -> float:
    """Return the light at a step, as a share of the usual; it drifts to and fro in a time, s."""
    turn = 2 * np.pi * (step + 0.5) * scenario.period_s / drift_s
    drifted = 1 + scenario.lighting_drift * float(np.sin(turn))
    return drifted * (1 + scenario.light_step * _has_stepped(scenario, step))


def gain(scenario: Scenario, step: int) -> float:
    """Return what the camera multiplies light and noise by at a step."""
    return 1 + scenario.gain_step * _has_stepped(scenario, step)


def _has_stepped(scenario: Scenario, step: int) -> bool:
    return (step + 0.5) * scenario.period_s >= scenario.step_s
