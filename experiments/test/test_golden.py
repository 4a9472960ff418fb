from pathlib import Path

import pytest

from mctrack_experiments.golden import NAME, golden_figures
from mctrack_ros.evaluation.figures import Figures

BAGS = Path(__file__).resolve().parents[2] / 'bags'


def test_the_golden_detections_give_the_stored_scores(tmp_path):
    stored = Figures.read(BAGS / f'{NAME}.json')
    found = golden_figures(BAGS / NAME, tmp_path)
    assert found.figures == pytest.approx(dict(stored.figures), abs=2e-3, nan_ok=True)
