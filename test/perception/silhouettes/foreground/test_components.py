import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis.extra.numpy import arrays

from mctrack_ros.perception.silhouettes.foreground.components import (
    MOST,
    ComponentConfig,
    find_silhouettes,
    shapes_of,
)

AS_IT_IS = ComponentConfig(opening_px=1, closing_px=1)


def flooded(mask):
    """Return the sets of connected pixels, by their first pixel row by row."""
    left, found = {tuple(place) for place in np.argwhere(mask)}, []
    for place in sorted(left):
        if place not in left:
            continue
        todo, component = [place], set()
        while todo:
            y, x = todo.pop()
            if (y, x) in left:
                left.remove((y, x))
                component.add((y, x))
                todo += [(y + down, x + right) for down in (-1, 0, 1) for right in (-1, 0, 1)]
        found.append(component)
    return found


@settings(deadline=None)
@given(arrays(np.bool_, (9, 11)), arrays(np.uint8, (9, 11)))
def test_silhouettes_are_the_connected_components_with_their_features(mask, grey):
    found = find_silhouettes(255 * mask.astype(np.uint8), grey, AS_IT_IS)
    components = {
        frozenset((int(y), int(x)) for y, x in np.argwhere(found.labels == index + 1)): index
        for index in range(len(found.shapes))
    }
    assert set(components) == {frozenset(component) for component in flooded(mask)}
    for component, index in components.items():
        y, x = np.array(sorted(component)).T
        expected = shapes_of(x, y, grey[y, x])
        assert np.allclose(found.shapes.vector[index], expected.vector[0])
        assert np.array_equal(found.shapes.box[index], expected.box[0])


def test_opening_removes_specks_and_moves_nothing():
    mask = np.zeros((40, 40), np.uint8)
    mask[10:20, 5:12] = 255
    mask[30, 30] = mask[25:27, 2:4] = 255
    found = find_silhouettes(mask, mask, ComponentConfig(opening_px=3))
    assert found.shapes.box.tolist() == [[5, 10, 7, 10]]


def test_more_components_than_can_be_tracked_are_noise():
    side = int(MOST**0.5) + 1
    mask = np.zeros((2 * side, 2 * side), np.uint8)
    mask[::2, ::2] = 255
    found = find_silhouettes(mask, mask, AS_IT_IS)
    assert len(found.shapes) == 0
    assert not found.labels.any()


@pytest.mark.parametrize('name', ['opening_px', 'closing_px'])
def test_kernels_that_would_shift_are_refused(name):
    with pytest.raises(ValueError, match=f'{name} is 4, expected an odd number'):
        ComponentConfig(**{name: 4})
