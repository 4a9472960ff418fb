from contextlib import contextmanager

from mctrack_experiments.bench.fusion import bench_fusion
from mctrack_experiments.bench.parts import Part


def test_figures_name_the_command_that_measures_them_again(here, folder):
    shown = []

    @contextmanager
    def show(title):
        yield lambda done, total: shown.append((title, done, total))

    figures = bench_fusion(folder, (), (Part.WHOLE,), (1, 2), quick=True, show=show)
    assert figures.command == 'mctrack bench fusion --part whole --quick --alone'
    assert figures.protocol['peers'] == 'none'
    assert figures.figures['whole.p50_ms'] > 0
    assert figures.figures['whole.idf1'] > 0.9
    assert shown[-1][1:] == (1, 1)
