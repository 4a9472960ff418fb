import pytest

from mctrack_ros.config import ConfigError
from mctrack_ros.ground import CalibrationError, file_format, read_calibration
from mctrack_ros.ground.yaml_files import read_yaml_documents, read_yaml_file
from mctrack_ros.site.site import load_site

BOMB = '\n'.join(
    ['a0: &a0 [1,1,1,1,1,1,1,1,1,1]']
    + [f'a{n}: &a{n} [{",".join([f"*a{n - 1}"] * 10)}]' for n in range(1, 9)]
)
MERGED = '\n'.join(
    ['a0: &a0 {x: 1, y: 2}']
    + [f'a{n}: &a{n} {{<<: [{",".join([f"*a{n - 1}"] * 10)}]}}' for n in range(1, 9)]
)


@pytest.mark.parametrize(
    ('text', 'reason'),
    [
        (BOMB, 'aliases unfold into more than'),
        (MERGED, 'aliases unfold into more than'),
        ('a: &a [*a]', 'aliases unfold into more than'),
        ('[' * 2000, 'nested too deeply'),
        ('{a', 'not a readable YAML file'),
        ('a: {b: 1, c: 2, b: 3}', 'b stands twice in it, again in line 1'),
        ('a: 2001-99-99', 'not a readable YAML file: month'),
    ],
)
@pytest.mark.parametrize(
    ('read', 'error'),
    [
        (load_site, ConfigError),
        (file_format, CalibrationError),
        (lambda path: read_calibration(path, (720, 576)), CalibrationError),
    ],
)
def test_yaml_that_unfolds_or_cannot_be_read_is_refused(tmp_path, text, reason, read, error):
    path = tmp_path / 'file.yaml'
    path.write_text(text)
    with pytest.raises(error, match=reason) as refusal:
        read(path)
    assert str(path) in str(refusal.value)
    assert '\n' not in str(refusal.value)


def test_aliases_of_a_reasonable_size_are_read(tmp_path):
    path = tmp_path / 'file.yaml'
    path.write_text('one: &one {a: 1}\ntwo: {<<: *one, b: 2}')
    assert read_yaml_file(path, ValueError) == {'one': {'a': 1}, 'two': {'a': 1, 'b': 2}}


def test_further_documents_are_refused_unless_they_are_expected(tmp_path):
    path = tmp_path / 'file.yaml'
    path.write_text('a: 1\n---\nb: 2')
    assert read_yaml_documents(path, ValueError) == [{'a': 1}, {'b': 2}]
    with pytest.raises(ValueError, match='several documents'):
        read_yaml_file(path, ValueError)
