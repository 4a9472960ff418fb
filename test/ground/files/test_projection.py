import numpy as np
import pytest

from mctrack_ros.ground import ProjectionError, read_projection

HOMOGRAPHY = [[20.0, 1.0, 300.0], [0.5, -8.0, 400.0], [0.0, 0.02, 1.0]]


def test_both_directions_of_a_homography_mean_the_same(tmp_path):
    (tmp_path / 'one.yaml').write_text(f'image_from_ground: {HOMOGRAPHY}')
    inverse = np.linalg.inv(HOMOGRAPHY).tolist()
    (tmp_path / 'other.yaml').write_text(f'ground_from_image: {inverse}')
    one, other = (
        read_projection(tmp_path / name, (768, 576)) for name in ('one.yaml', 'other.yaml')
    )
    pixel = [[100.0, 400.0], [500.0, 350.0]]
    np.testing.assert_allclose(one.ground_from_image(pixel), other.ground_from_image(pixel))


@pytest.mark.parametrize(
    ('text', 'reason'),
    [
        ('{', 'not a readable YAML file'),
        ('homography: [[1]]', 'expected exactly one of the keys'),
        ('image_from_ground: [[1, 0], [0, 1]]', r'shape \(2, 2\), expected \(3, 3\)'),
        ('image_from_world: [[1, 0], [0]]', 'inhomogeneous'),
        ('image_from_ground: [[0, 0, 0], [0, 0, 0], [0, 0, 0]]', 'singular'),
        (
            'ground_from_image: [[1, 0, 0], [1, 0, 0], [0, 0, 1]]',
            'ground_from_image is singular: it takes',
        ),
        ('image_from_ground: [[.nan, 0, 0], [0, 1, 0], [0, 0, 1]]', 'finite'),
    ],
)
def test_projections_that_cannot_be_used_are_refused_by_file_and_reason(tmp_path, text, reason):
    path = tmp_path / 'projection.yaml'
    path.write_text(text)
    with pytest.raises(ProjectionError, match=reason) as refusal:
        read_projection(path, (768, 576))
    assert str(path) in str(refusal.value)
    assert '\n' not in str(refusal.value)
