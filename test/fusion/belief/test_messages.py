"""Messages between the ground and the views: exact where that is known."""

import numpy as np
import pytest

from mctrack_ros.fusion.belief.messages import ViewSamples, potential, propagate
from mctrack_ros.tracking.particles import normalised

N = 2000
PRIOR = -0.5
"""Log-density of a standard normal number, for its square."""
POTENTIAL = 0.2
ZERO = np.array([0])


def view(rng, measured, variance, sets=1):
    """Return standard normal samples of one axis, and the likelihood of a measurement."""
    state = np.zeros((sets, N, 4))
    state[..., 0] = rng.normal(size=(sets, N))
    spread = np.broadcast_to(np.diag([POTENTIAL, 1e-3]), (sets, N, 2, 2))
    log = -((state[..., 0] - measured) ** 2) / (2 * variance), PRIOR * state[..., 0] ** 2
    return ViewSamples.of(np.arange(sets), state, spread, (1e-3, 1e-3), log)


def on_ground(rng, sets=1):
    state = np.zeros((sets, N, 4))
    state[..., 0] = rng.normal(size=(sets, N))
    return state


def moments(state, weight):
    mean = (weight * state[..., 0]).sum(axis=-1)
    return mean, (weight * (state[..., 0] - mean[..., None]) ** 2).sum(axis=-1)


@pytest.mark.parametrize(
    ('weights', 'mean', 'variance'),
    [
        # All standard normal: messages of mean z / (1 + r), variance s + 1 / (1 + 1 / r).
        ('corrected', 0.658, 0.2105),
        # The view's prior counts twice, z / (1 + 2 r) and s + 1 / (2 + 1 / r); with two views the
        # ground's not at all.
        ('printed', 0.625, 0.225),
        # The view's samples about x weigh alike: likelihood of x / (1 + s), r + s / (1 + s).
        ('evidence', 1.0135, 0.3243),
    ],
)
def test_two_gaussian_views_are_exact_and_as_printed_too_near_to_the_prior(
    weights, mean, variance
):
    """Variances r = .5 of measurements 1 and 1.5, s = .2 of the potential."""
    rng = np.random.default_rng(1)
    ground = on_ground(rng, 40)
    views = [view(rng, 1.0, 0.5, 40), view(rng, 1.5, 0.5, 40)]
    prior = PRIOR * ground[..., 0] ** 2 if weights == 'printed' else None
    found = moments(ground, propagate(ground, views, 1e-9, weights, prior).ground)
    assert found[0].mean() == pytest.approx(mean, abs=0.008)
    assert found[1].mean() == pytest.approx(variance, abs=0.004)


def test_printed_weights_are_the_printed_formula():
    rng = np.random.default_rng(5)
    ground = on_ground(rng)[:, :30]
    views = [
        ViewSamples(*(each[:, :20] if np.ndim(each) > 1 else each for each in one))
        for one in (view(rng, 1.0, 0.5), view(rng, 0.5, 0.3))
    ]
    prior = rng.normal(size=(1, 30))
    found = propagate(ground, views, 0.05, 'printed', prior)
    kernels = [potential(ground, each, 0.05)[0][0].astype(float) for each in views]
    likelihood, own = (
        [np.exp(getattr(each, name)[0]) for each in views]
        for name in ('log_likelihood', 'log_prior')
    )
    density = np.exp(prior[0])
    told = [k @ (p * q) / density for k, p, q in zip(kernels, likelihood, own)]
    told = [each / each.sum() for each in told]
    pi = told[0] * told[1] * density
    np.testing.assert_allclose(found.ground[0], pi / pi.sum(), rtol=1e-3)
    heard = (told[1] * density) @ kernels[0] / own[0]
    pi = likelihood[0] * heard * own[0]
    np.testing.assert_allclose(found.views[0][0], pi / pi.sum(), rtol=1e-3)


def test_a_view_that_sees_nothing_tells_nothing_and_is_told_where_the_target_is():
    rng = np.random.default_rng(4)
    ground = on_ground(rng)
    clear, dark = view(rng, 1.0, 0.05), view(rng, 0.0, 1e9)
    result = propagate(ground, [clear, dark], 0.02)
    alone = propagate(ground, [clear], 0.02)
    assert moments(ground, result.ground)[0] == pytest.approx(
        moments(ground, alone.ground)[0], abs=0.15
    )
    weights = [normalised(message[0]) for message in result.to_ground]
    told, heard = (-(each * np.log(each)).sum() for each in weights)
    assert heard > told + 0.1
    assert moments(dark.state, result.views[1])[0] > 0.4
    assert np.abs(moments(dark.state, normalised(dark.log_likelihood))[0]) < 0.1


def test_where_a_target_is_hidden_the_message_is_flat_and_the_view_is_told_all_the_same():
    rng = np.random.default_rng(4)
    ground, clear = on_ground(rng), view(rng, 1.0, 0.05)
    flat = np.full((1, N), -8.0)
    occluded = view(rng, 0.0, 1.0)._replace(log_likelihood=flat, hidden=-8.0)
    result = propagate(ground, [clear, occluded], 0.02)
    alone = propagate(ground, [clear], 0.02)
    np.testing.assert_allclose(
        moments(ground, result.ground), moments(ground, alone.ground), atol=0.1
    )
    assert moments(occluded.state, result.views[1])[0] > 0.4


def test_a_silent_view_sends_a_flat_message():
    rng = np.random.default_rng(4)
    ground = on_ground(rng, 2)
    only_second = view(rng, 1.0, 0.05)._replace(target=np.array([1]))
    result = propagate(ground, [only_second], 0.02)
    np.testing.assert_array_equal(result.to_ground[0, 0], 0.0)
    np.testing.assert_allclose(result.ground[0], 1 / N)
    assert result.ground[1].max() > 2 / N


def test_targets_do_not_mix():
    rng = np.random.default_rng(6)
    ground, both = on_ground(rng, 2), view(rng, 1.0, 0.5, 2)
    result = propagate(ground, [both], 0.05)
    for row in range(2):
        one = ViewSamples(ZERO, *(each[row : row + 1] for each in both[1:-1]), both.hidden)
        alone = propagate(ground[row : row + 1], [one], 0.05)
        np.testing.assert_allclose(result.ground[row], alone.ground[0], rtol=1e-5)
        np.testing.assert_allclose(result.views[0][row], alone.views[0][0], rtol=1e-5)


def test_the_outlier_term_keeps_far_particles_alive():
    ground = np.zeros((1, 2, 4))
    ground[0, 1, 0] = 3.0
    nothing = np.zeros((1, 1))
    one = ViewSamples.of(
        ZERO, np.zeros((1, 1, 4)), 0.01 * np.eye(2)[None, None], (0.01, 0.01), (nothing, nothing)
    )
    with_it, without = (potential(ground, one, share)[0][0] for share in (0.05, 0.0))
    assert with_it[1, 0] > 0
    assert without[1, 0] < 1e-20 * with_it[1, 0]
    assert with_it[0, 0] > with_it[1, 0]


def test_no_views_leave_the_prediction():
    ground = np.random.default_rng(1).normal(size=(1, 50, 4))
    np.testing.assert_allclose(propagate(ground, [], 0.05).ground, 1 / 50)
