"""The event-tracking paper's Experiment III (Table 4): events and identities on the pitch."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from mctrack_experiments.papers.event_tracking.beginning import (
    BEGINNING_S,
    Beginning,
    beginning_figures,
)
from mctrack_experiments.papers.event_tracking.happenings import (
    CODES,
    DOUBTFUL,
    EventScore,
    Happening,
    score_events,
)
from mctrack_experiments.papers.event_tracking.paths import matched_paths
from mctrack_experiments.papers.event_tracking.tracked_match import (
    MEMORY_S,
    PEOPLE_GATE_M,
    TrackedMatch,
)
from mctrack_ros.evaluation import (
    Trajectories,
    evaluate_ground,
    ground_timeline,
    identity_switches,
    while_isolated,
)
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.interfaces import EventCode
from mctrack_ros.simulation import Scenario, World

DURATION_S = 120.0
WINDOW_S = 0.5
GATE_M = 1.0
MAJORITY = 0.5
APART_M, APART_S = 3.0, 1.0
"""Who has nobody nearer than this, from so long before on, is isolated."""

Progress = Callable[[str], None]


def reproduce_table4(
    seeds: Sequence[int],
    duration_s: float = DURATION_S,
    progress: Progress = lambda line: None,
) -> Figures:
    """
    Track matches that nothing was tuned on and hold every camera's events against the truth.

    Parameters
    ----------
    seeds : sequence of int
        One match each.
    duration_s : float
        Length of each, s.
    progress : callable
        Told what is being done.

    """
    scores = [{code: EventScore() for code in CODES} for _ in range(2)]
    kept, correlations, kits, tracking = [], [], [], []
    beginnings: dict[str, list[Beginning]] = {'given': [], 'first_pass': [], 'learned': []}
    for seed in seeds:
        with tempfile.TemporaryDirectory() as scratch:
            progress(f'seed {seed}: rendering and tracking {duration_s:g} s')
            world = World.simulated(Scenario(seed=seed, duration_s=duration_s))
            match = TrackedMatch.made(world, Path(scratch))
            for camera in match.cameras:
                _add_scores(scores, *match.happenings(camera))
            beginnings['given'].append(Beginning.of(match, GATE_M))
            truth, tracks = match.trajectories()
            kits.append(match.kits(GATE_M))
        switched = np.unique(ground_timeline(truth, tracks, GATE_M).switch_truth_id)
        kept.append(1 - len(switched) / len(np.unique(truth.id)))
        correlations.append(_correlation(truth, tracks))
        tracking.append(_tracking(truth, tracks, world.scenario))
        short = replace(world.scenario, duration_s=min(BEGINNING_S, duration_s))
        for first_pass, name in ((True, 'first_pass'), (False, 'learned')):
            progress(f'seed {seed}: its beginning, backgrounds learned')
            with tempfile.TemporaryDirectory() as scratch:
                match = TrackedMatch.made(
                    World.simulated(short), Path(scratch), is_given=False, first_pass=first_pass
                )
                beginnings[name].append(Beginning.of(match, GATE_M))
    figures: dict[str, float] = {}
    for code, exact, majority in zip(range(1, 6), scores[0].values(), scores[1].values()):
        figures |= _figures(f'e{code}', exact) | {f'e{code}.majority.f1': majority.f1}
        if exact.doubted:
            figures[f'e{code}.doubted'] = exact.doubted
            figures[f'e{code}.doubted.precision'] = exact.doubted_precision
    figures |= {name: float(np.mean([one[name] for one in tracking])) for name in tracking[0]}
    for name, found in beginnings.items():
        figures |= beginning_figures(name, found)
    figures |= {
        'correlation': float(np.mean(correlations)),
        'one_id_share': float(np.mean(kept)),
        'kits.purity': float(np.mean([kit.purity for kit in kits])),
        'kits.found': float(np.mean([kit.found for kit in kits])),
    }
    return Figures(
        name='table4',
        command='mctrack reproduce table4',
        protocol=_protocol(seeds, duration_s),
        figures=figures,
    )


def _add_scores(
    scores: Sequence[dict[EventCode, EventScore]],
    true: Sequence[Happening],
    told: Sequence[Happening],
) -> None:
    """Add one camera's events, of the same targets and of most of them."""
    for code in CODES:
        for score, alike in zip(scores, (1.0, MAJORITY)):
            score[code] += score_events(_of(code, true), _of(code, told), WINDOW_S, alike)


def _of(code: int, happenings: Sequence[Happening]) -> list[Happening]:
    return [happening for happening in happenings if happening.event == code]


def _correlation(truth: Trajectories, tracks: Trajectories) -> float:
    """Return the mean over players and axes of true and estimated coordinates' correlation."""
    paths = matched_paths(truth, tracks, GATE_M).values()
    return float(np.mean([path.correlation() for path in paths if len(path.frame) > 2]))


def _tracking(truth: Trajectories, tracks: Trajectories, scenario: Scenario) -> dict[str, float]:
    """Return the scores of one match on the ground."""
    scores = evaluate_ground(truth, tracks, GATE_M)
    switches = identity_switches(truth, tracks, GATE_M)
    alone = while_isolated(switches, truth, APART_M, round(APART_S * scenario.rate_hz))
    return {
        'mota': scores.mota,
        'idf1': scores.idf1,
        'hota': scores.hota,
        'error_m': scores.mean_distance,
        'switches_a_minute': 60 * scores.switches / scenario.duration_s,
        'switches_isolated': float(alone.sum()),
    }


def _figures(name: str, score: EventScore) -> dict[str, float]:
    return {
        f'{name}.true': score.true,
        f'{name}.told': score.told,
        f'{name}.ratio': score.ratio,
        f'{name}.precision': score.precision,
        f'{name}.recall': score.recall,
        f'{name}.f1': score.f1,
        f'{name}.promised': score.promised,
    }


def _protocol(seeds: Sequence[int], duration_s: float) -> dict[str, Any]:
    return {
        'scene': f'pitch5, {duration_s:g} s, 5 cameras, 25 people',
        'seeds': f'{", ".join(map(str, seeds))}; the tracker is tuned on 1 to 6, 61 and 62',
        'background': 'an image of the empty pitch, given to each camera: one JPEG, with noise',
        'given, first_pass, learned': f'the first {BEGINNING_S:g} s with that image, with '
        'backgrounds learned from all of them beforehand, and from the first images, as live '
        'nodes do: F1 of E1 within a time, its median delay, MOTA',
        'pair': f'same camera, within {WINDOW_S:g} s, the same targets (all members of a group); '
        'majority: at least half of all that either names',
        'targets': 'a track is the person it is nearest to most often within '
        f'{MEMORY_S:g} s, at most {PEOPLE_GATE_M:g} m away',
        'promised': 'share that would be true had each been as probable as told; doubted: those '
        f'told as less probable than {DOUBTFUL:g}, and the share of them that is true',
        'correlation': f'of true and estimated x and y at {GATE_M:g} m, mean over players',
        'mota': f'and others, on the ground at {GATE_M:g} m, means over the matches; '
        f'switches_isolated: of those who had nobody within {APART_M:g} m for {APART_S:g} s',
        'one_id_share': 'players who are never switched to another id',
        'kits': f'of global tracks within {GATE_M:g} m of somebody; purity: share of those whose '
        'kit is known that wear what most of that kit do',
    }
