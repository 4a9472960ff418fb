import pytest

from mctrack_experiments.bench.fusion.toolkit import Toolkit, toolkit_folder


def test_a_missing_benchmark_is_named_in_one_line(tmp_path):
    with pytest.raises(OSError, match=r'generate\.py.*MCTRACK_BENCH') as refused:
        Toolkit(tmp_path)
    assert '\n' not in str(refused.value)


def test_the_folder_is_the_given_one_or_that_of_the_environment(monkeypatch, tmp_path):
    monkeypatch.setenv('MCTRACK_BENCH', str(tmp_path))
    assert toolkit_folder() == tmp_path
    assert toolkit_folder(tmp_path / 'other') == tmp_path / 'other'


def test_scenes_are_those_of_the_generator(toolkit, scene):
    assert scene.scenario.truth.shape == (50, 25, 2)
    assert scene.scenario.cameras == 5
    assert toolkit.scene(10, 1, targets=3).scenario.truth.shape == (10, 3, 2)
