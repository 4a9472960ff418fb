import numpy as np
import pytest

from mctrack_ros.simulation import CameraRenderer, Scenario, World

OPTIONS = [
    {'shadows': True},
    {'lighting_drift': 0.2},
    {'distortion': -0.1},
    {'noise': 6.0},
    {'light_step': -0.3, 'step_s': 0.0},
    {'gain_step': 0.3, 'step_s': 0.0},
]


def test_any_order_of_steps_gives_the_same_bytes():
    world = World.simulated(Scenario(seed=3, duration_s=0.4))
    renderer = CameraRenderer(world, 1)
    forwards = [renderer.frame(step)[0] for step in (2, 7)]
    other = CameraRenderer(World.simulated(Scenario(seed=3, duration_s=0.4)), 1)
    backwards = [other.frame(step)[0] for step in (7, 2)]
    np.testing.assert_array_equal(forwards, backwards[::-1])


def test_another_seed_is_another_match():
    first, second = (World.simulated(Scenario(seed=s, duration_s=0.2)) for s in (1, 2))
    assert not np.array_equal(first.motion.position, second.motion.position)


def test_noise_differs_from_image_to_image(staged):
    renderer = CameraRenderer(staged({}, duration_s=0.2, noise=2.0), 0)
    difference = renderer.frame(0)[0].astype(float) - renderer.frame(1)[0]
    assert difference.std() == pytest.approx(2 * np.sqrt(2), rel=0.1)


def test_image_of_the_empty_pitch_is_noisy_as_the_others_and_always_the_same(staged):
    renderer = CameraRenderer(staged({}, duration_s=0.2, noise=2.0), 0)
    empty = renderer.empty()
    difference = renderer.frame(0)[0].astype(float) - empty
    assert difference.std() == pytest.approx(2 * np.sqrt(2), rel=0.1)
    np.testing.assert_array_equal(renderer.empty(), empty)


def test_pixels_change_only_inside_the_true_box(staged):
    empty, _ = CameraRenderer(staged({}), 0).frame(0)
    image, view = CameraRenderer(staged({3: (20, 30)}), 0).frame(0)
    rows, columns = np.nonzero((image != empty).any(axis=2))
    left, top, width, height = view.box[0]
    assert (columns.min(), rows.min()) == (left, top)
    assert (columns.max() + 1, rows.max() + 1) == (left + width, top + height)
    assert len(rows) == view.pixels[0]


@pytest.mark.parametrize('options', OPTIONS, ids=lambda options: next(iter(options)))
def test_options_change_the_image_but_not_what_happens(options):
    plain, other = (World.simulated(Scenario(duration_s=0.2, **given)) for given in ({}, options))
    np.testing.assert_array_equal(plain.motion.position, other.motion.position)
    (image, view), (changed, seen) = (CameraRenderer(w, 0).frame(3) for w in (plain, other))
    assert (image != changed).any()
    assert np.array_equal(view.box, seen.box) == ('distortion' not in options)


def test_shadows_darken_grass_beside_people(staged):
    bare, _ = CameraRenderer(staged({3: (20, 30)}), 0).frame(0)
    shaded, view = CameraRenderer(staged({3: (20, 30)}, shadows=True), 0).frame(0)
    assert (shaded <= bare).all()
    assert np.count_nonzero((shaded < bare).any(axis=2)) > 0.2 * view.pixels[0]


def test_a_scenario_without_noise_is_refused():
    with pytest.raises(ValueError, match='noise is 0'):
        Scenario(noise=0)


def test_a_gain_step_makes_light_and_noise_more_from_one_image_to_the_next(staged):
    plain = CameraRenderer(staged({}, duration_s=0.4), 0)
    stepped = CameraRenderer(staged({}, duration_s=0.4, gain_step=0.3, step_s=0.2), 0)
    assert np.array_equal(plain.frame(4)[0], stepped.frame(4)[0])
    before, after = plain.frame(5)[0].astype(float), stepped.frame(5)[0].astype(float)
    dark = before < 190
    np.testing.assert_allclose(after[dark], before[dark] * 1.3, atol=0.51)


def test_light_steps_and_drift_are_of_the_light_alone(staged):
    quiet, noisy = (
        CameraRenderer(staged({}, duration_s=0.4, light_step=-0.3, step_s=0.2, noise=noise), 0)
        for noise in (0.1, 4.0)
    )
    for step in (4, 5):
        noise = noisy.frame(step)[0].astype(float) - quiet.frame(step)[0]
        assert noise.std() == pytest.approx(4.0, rel=0.05)


@pytest.mark.parametrize('name', ['light_step', 'gain_step'])
def test_a_scenario_without_any_light_is_refused(name):
    with pytest.raises(ValueError, match=f'{name} is -1'):
        Scenario(**{name: -1.0})
