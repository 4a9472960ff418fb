"""Who crosses from cell to cell, and who keeps an id."""

import numpy as np
import pytest

from mctrack_experiments.bench.cells import bench, play, site
from mctrack_experiments.bench.cells.live import bench_cells_live
from mctrack_experiments.bench.cells.site import TICK_S, CellSite, cell_site
from ros_domains import free_domain


def ticks(seconds):
    return round(seconds / TICK_S)


def walk(seconds, start, speed):
    """Return the places of one who goes along x."""
    x = start + speed * np.arange(ticks(seconds)) * TICK_S
    return np.column_stack([x, np.full(len(x), 10.0)])


@pytest.fixture
def crossing():
    """Return a site whose first border is at 30 m and whose second is at 60 m."""
    paths = np.stack([walk(60, 10.0, 1.0), walk(60, 35.0, 1.0), walk(60, 31.0, 0.0)], axis=1)
    return CellSite(paths, np.zeros(4, int), [], (np.array([30.0, 60.0]), np.array([40.0])))


def test_crossings_are_found_by_kind_of_border_once_cells_have_settled(crossing):
    found = bench.crossings_of(crossing)
    assert found['gap'].tolist() == [[ticks(20) + 1, 0]]
    assert found['overlap'].tolist() == [[ticks(25) + 1, 1], [ticks(50) + 1, 0]]


def test_an_id_is_kept_if_it_is_the_same_and_none_is_missing_for_long(crossing):
    crossings = bench.crossings_of(crossing)['gap']
    ids = np.zeros(crossing.paths.shape[:2], int)
    ids[:, 0] = 7
    assert bench.is_kept(ids, crossings).all()
    ids[ticks(20) : ticks(26), 0] = 0
    assert bench.is_kept(ids, crossings).all()
    assert not bench.is_kept(ids, crossings, bench.LONG_S).any()
    ids[ticks(26) :, 0] = 8
    assert not bench.is_kept(ids, crossings).any()
    ids[ticks(20) :, 0] = 0
    assert not bench.is_kept(ids, crossings).any()


def test_a_site_in_cells_is_tracked_with_one_id_for_each(monkeypatch):
    monkeypatch.setattr(site, 'SECONDS', 4.0)
    monkeypatch.setattr(site, 'PEOPLE', 4)
    made = cell_site(seed=1, cells=4)
    assert sum(scene.scenario.cameras for scene in made.scenes) == 100
    cells, arrivals = play.play_cells(made, seed=1)
    fused = play.play_site(arrivals, len(cells))
    assert len(cells[1].tracks) * 2 == len(cells[0].tracks) == len(made.paths)
    assert [each.arrival_ns for each in arrivals] == sorted(each.arrival_ns for each in arrivals)
    ids = bench.ids_of(made.paths, fused.tracks)
    assert all(len(set(column[column > 0].tolist())) <= 1 for column in ids.T)
    assert (ids[-5:] > 0).any()


@pytest.mark.live
def test_ids_are_kept_between_cells_that_are_processes_and_the_load_of_each_is_told(monkeypatch):
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    with free_domain() as domain:
        monkeypatch.setenv('ROS_DOMAIN_ID', str(domain))
        figures = bench_cells_live(every=4).figures
    assert figures['ticks'] > 60
    assert figures['kept'] > 0.7
    loads = {name: value for name, value in figures.items() if 'core' in name}
    assert loads.keys() >= {'cell.core', 'cell.core_worst', 'site.core', 'player.core'}
    assert all(0 < value < 1 for value in loads.values())
