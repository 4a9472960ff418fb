import pytest

from mctrack_experiments.papers.silhouettes.classes import KINDS, reproduce_classes


@pytest.fixture(scope='module')
def figures(here):
    return reproduce_classes(seeds=(5,), duration_s=40)


def test_every_kind_comes_and_most_are_told_for_what_they_are(figures):
    values = figures.figures
    for name in KINDS:
        assert values[f'{name}.number'] >= 2
        assert values[f'{name}.found'] > 0.5
        assert values[f'{name}.right'] > 0.8
        assert values[f'{name}.low'] <= values[f'{name}.right'] <= values[f'{name}.high']
    assert values['bicycles.local_ids'] < 2
    assert values['bicycles.error_median_m'] < 0.3


@pytest.mark.filterwarnings('ignore::RuntimeWarning')  # nobody of some kinds
def test_figures_are_reproducible_and_say_what_they_are(here, figures):
    first, again = (reproduce_classes(seeds=(1,), duration_s=5).figures for _ in range(2))
    assert list(again.values()) == pytest.approx(list(first.values()), nan_ok=True)
    assert 'tuned on 1 to 3' in figures.protocol['seeds']
