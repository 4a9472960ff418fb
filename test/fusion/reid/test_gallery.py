import numpy as np

from mctrack_ros.fusion.reid.gallery import STRANGE, AppearanceSample, Gallery
from mctrack_ros.interfaces import TEMPLATE_SIZE


def look(*bins, seconds=5.0, noise=None):
    mean = np.zeros(TEMPLATE_SIZE)
    mean[list(bins)] = 1 / np.sqrt(len(bins))
    return AppearanceSample(mean if noise is None else mean + noise, seconds)


def test_one_is_more_like_himself_than_like_another():
    gallery = Gallery()
    gallery.learn(1, look(1, 2))
    gallery.learn(2, look(1, 3))
    seen = look(1, 2, noise=0.01)
    assert gallery.difference(seen, 1) < gallery.difference(seen, 2)


def test_one_who_is_not_known_differs_as_strangers_do():
    gallery = Gallery()
    gallery.learn(1, look(1))
    assert gallery.difference(look(1), 2) == STRANGE


def test_nothing_is_told_before_it_is_learned_how_people_differ_from_themselves():
    gallery = Gallery()
    gallery.learn(1, look(1))
    assert gallery.weight(look(1)) == 0.0
    for _ in range(20):
        gallery.learn(1, look(1, noise=0.01))
    short, long = (gallery.weight(look(1, seconds=each)) for each in (0.5, 10.0))
    assert 0.0 < short < long < 1.0
    assert gallery.weight(look(1, seconds=0.0)) == 0.0


def test_one_who_is_hardly_known_may_look_different():
    gallery = Gallery()
    gallery.learn(1, look(1))
    gallery.learn(2, look(1, seconds=0.5))
    seen = look(1, noise=0.05)
    assert gallery.difference(seen, 2) < gallery.difference(seen, 1)


def test_by_what_everybody_differs_from_himself_is_not_told_apart():
    """Light changes bins 1 and 2 of everybody; bins 3 and 4 only by who it is."""
    rng = np.random.default_rng(1)
    gallery = Gallery()
    for _ in range(40):
        for person, own in ((1, 3), (2, 4)):
            light = np.zeros(TEMPLATE_SIZE)
            light[[1, 2]] = rng.normal(0, 0.1) * np.array([1, -1])
            gallery.learn(person, look(1, 2, own, noise=light))
    changed = np.zeros(TEMPLATE_SIZE)
    changed[[1, 2]] = 0.1, -0.1
    by_light = gallery.distance(look(1, 2, 3, noise=changed).mean, 1)
    other = np.zeros(TEMPLATE_SIZE)
    other[[5, 6]] = 0.1, -0.1
    assert by_light < gallery.distance(look(1, 2, 3, noise=other).mean, 1) / 3


def test_a_portrait_follows_slow_change_and_can_be_forgotten():
    gallery = Gallery()
    for step in range(60):
        gallery.learn(1, look(1, noise=step * 0.002))
    assert gallery.distance(look(1, noise=0.118).mean, 1) < gallery.distance(look(1).mean, 1)
    assert 1 in gallery
    gallery.forget(1)
    assert 1 not in gallery
    assert gallery.difference(look(1), 1) == STRANGE
