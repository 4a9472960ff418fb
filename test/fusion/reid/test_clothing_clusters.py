import numpy as np
import pytest

from mctrack_ros.fusion.reid.clothing_clusters import PROVEN_S, ClothingClusters
from mctrack_ros.fusion.table import TrackTable

SECOND_NS = 1_000_000_000
TEAMS = {'red': (0, 20), 'blue': (8, 25), 'yellow': (2, 40)}


def batch(rng, team, count):
    """Templates of people who wear a team's colours, each a little differently."""
    template = np.zeros((count, 48))
    template[:, TEAMS[team]] = 0.5
    template += rng.uniform(0, 0.01, template.shape)
    return template / template.sum(axis=1, keepdims=True)


def tracks(template, first_ns=-10 * SECOND_NS):
    table = TrackTable.blank(len(template), 2)
    table.track_id[:] = np.arange(1, len(template) + 1)
    table.template[:] = template
    table.first_ns[:], table.confirmed[:], table.cameras[:] = first_ns, True, 1
    return table


def match(seed=1, players=11, referees=2):
    rng = np.random.default_rng(seed)
    sizes = {'red': players, 'blue': players, 'yellow': referees}
    table = tracks(np.concatenate([batch(rng, team, count) for team, count in sizes.items()]))
    return table, np.repeat([1, 2, 3], list(sizes.values()))


def watch(table, seconds=20, kits=None, start_s=0):
    kits = kits or ClothingClusters()
    for stamp_s in np.arange(start_s, start_s + seconds, 0.5):
        kits.step(table, round(stamp_s * SECOND_NS))
    return kits


def same(kit):
    return kit[:, None] == kit


def test_as_many_kits_are_found_as_are_worn():
    table, team = match()
    watch(table)
    assert (table.kit > 0).all()
    assert np.array_equal(same(table.kit), same(team))


def test_one_of_his_own_is_a_kit():
    table, team = match(referees=1)
    watch(table)
    assert np.array_equal(same(table.kit), same(team))


@pytest.mark.parametrize('seed', range(3))
def test_the_order_of_tracks_does_not_matter_to_who_is_alike(seed):
    table, team = match()
    order = np.random.default_rng(seed).permutation(len(table))
    table = table.select(order)
    watch(table)
    assert np.array_equal(same(table.kit), same(team[order]))


def test_a_kit_has_no_number_before_it_has_been_worn_for_a_while():
    table, _ = match()
    kits = watch(table, PROVEN_S - 0.5)
    assert not table.kit.any()
    watch(table, 1.5, kits, PROVEN_S - 0.5)
    assert table.kit.all()


def test_a_kit_keeps_its_number_when_nobody_wears_it_and_when_all_drift():
    table, _ = match()
    kits = watch(table)
    before = table.kit.copy()
    reds = table.kit == table.kit[0]
    watch(table.select(~reds), 60, kits, 20)
    rng = np.random.default_rng(5)
    for step in range(20):
        table.template += 0.0005 * rng.uniform(0, 1, 48)
        table.template /= table.template.sum(axis=1, keepdims=True)
        watch(table, 2, kits, 80 + 2 * step)
    assert np.array_equal(table.kit, before)


def test_a_look_of_a_moment_founds_no_kit():
    table, _ = match()
    kits = watch(table)
    before, template = table.kit.copy(), table.template[0].copy()
    table.template[0] = np.eye(48)[30]
    watch(table, 1, kits, 20)
    assert np.array_equal(table.kit, before)
    table.template[0] = template
    watch(table, 20, kits, 21)
    assert np.array_equal(table.kit, before)


def test_one_who_changes_gets_another_kit():
    table, team = match()
    kits = watch(table)
    table.template[0] = table.template[team == 2].mean(axis=0)
    watch(table, 1, kits, 20)
    assert table.kit[0] == table.kit[team == 2][0]


def test_young_unconfirmed_hidden_and_grouped_tracks_are_not_judged():
    table, _ = match()
    table.first_ns[0] = 20 * SECOND_NS
    table.confirmed[1] = False
    table.cameras[2] = 0
    table.group[3] = 4
    table.template[4] = 0
    watch(table)
    assert not table.kit[:5].any()
    assert table.kit[5:].all()


def test_time_that_steps_back_is_no_trouble():
    table, team = match()
    kits = watch(table)
    watch(table, 5, kits, -100)
    assert np.array_equal(same(table.kit), same(team))
