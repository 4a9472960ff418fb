import numpy as np
import pytest

from mctrack_experiments.papers.silhouettes.classes import DURATION_S, KINDS, reproduce_classes


@pytest.fixture(scope='module')
def figures():
    return reproduce_classes(seeds=(1,), duration_s=DURATION_S / 10)


def test_every_kind_comes_and_most_are_told_for_what_they_are(figures):
    values = figures.figures
    for name in KINDS:
        assert values[f'{name}.number'] >= 2
        assert values[f'{name}.found'] > 0.5
        assert values[f'{name}.right'] > 0.8
        assert values[f'{name}.low'] <= values[f'{name}.right'] <= values[f'{name}.high']
    assert values['bicycles.local_ids'] < 2
    assert values['bicycles.error_median_m'] < 0.3


def test_figures_are_reproducible_and_say_what_they_are(figures):
    again = reproduce_classes(seeds=(1,), duration_s=DURATION_S / 10)
    assert np.allclose(list(again.figures.values()), list(figures.figures.values()))
    assert 'tuned on 1 to 3' in figures.protocol['seeds']
