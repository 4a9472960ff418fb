"""All scenarios over their seeds, as rates with their intervals."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from mctrack_experiments.bench.workers import run_spread
from mctrack_experiments.scenarios.staged import blind_area as blind
from mctrack_experiments.scenarios.staged import coalescence as pairs
from mctrack_experiments.scenarios.staged import ghosts, hand_over, swapped_kits
from mctrack_experiments.scenarios.staged.rates import rate_figures
from mctrack_ros.evaluation.figures import Figures

Outcome = dict[str, bool]
Progress = Callable[[int, int], None]

SCENARIOS: dict[str, tuple[Callable[..., Outcome], tuple[str, ...]]] = {
    **{
        f'ghost.{kind}{credulity}': (ghosts.ghost, (kind, credulity))
        for kind in ghosts.GHOSTS
        for credulity in ghosts.CREDULITY
    },
    **{
        f'coalescence.{way}.{kits}.{method}': (pairs.coalescence, (way, kits, method))
        for way in pairs.WAYS
        for kits in pairs.KITS
        for method in pairs.ASSOCIATORS
    },
    **{
        f'hand_over.{gap}.{people}': (hand_over.hand_over, (gap, people))
        for gap in hand_over.GAPS
        for people in hand_over.PEOPLE
    },
    **{f'stranger.{kits}': (hand_over.stranger, (kits,)) for kits in hand_over.STRANGERS},
    **{f'blind_area.{people}': (blind.blind_area, (people,)) for people in blind.PEOPLE},
    **{
        f'swapped_kits.{group}': (swapped_kits.swapped_kits, (group,))
        for group in swapped_kits.GROUPS
    },
}
"""What is played, with what, by name."""


def reproduce_scenarios(
    seeds: Sequence[int], progress: Progress = lambda done, total: None
) -> Figures:
    """
    Play every scenario once for each seed.

    Parameters
    ----------
    seeds : sequence of int
        Of all that is left to chance.
    progress : callable
        Told how many are done, of how many.

    """
    jobs = [(name, seed) for name in SCENARIOS for seed in seeds]
    outcomes = run_spread(_played, jobs, progress)
    figures: dict[str, float] = {}
    for index, name in enumerate(SCENARIOS):
        mine = outcomes[index * len(seeds) : (index + 1) * len(seeds)]
        for measure in mine[0]:
            chosen = [outcome[measure] for outcome in mine]
            figures |= rate_figures(f'{name}.{measure}', chosen)
    return Figures('scenarios', 'mctrack reproduce scenarios', _protocol(seeds), figures)


def _played(job: tuple[str, int]) -> Outcome:
    name, seed = job
    scenario, arguments = SCENARIOS[name]
    return scenario(seed, *arguments)


def _protocol(seeds: Sequence[int]) -> dict[str, str]:
    return {
        'scenes': 'detections on the ground, 25 ticks a second, through the real fusion and its '
        'feedback; each camera detects 92 % of whom it sees, takes those nearer than 0.45 m '
        'across and 4 m along its line of sight for one, has false detections, is 0.1 m off',
        'seeds': f'{min(seeds)} to {max(seeds)}; developed on 1 to 20',
        'rate, low, high': 'share of the seeds, and its 95 % interval (Wilson)',
        'ghost': 'told: feedback alone tells of it; one_camera, two_cameras: so many detect it, '
        'for 2 s; credulous: a camera detects whom it is told of near it in 2 % of its images, '
        'be he there or not; dies: not reported later than 1 s after its cause; never: not at all',
        'coalescence': 'side by side for 4 s, or crossing at 10 to 25 degrees; places: cameras '
        'tell places alone; kept: the ids after are those before; two: neither is without a '
        'track for 1 s',
        'hand_over': 'along two cameras that share 2 to 6 m, or leave 3 to 6 m unseen (2 to 5 s); '
        'two side by side, or opposite: passing in the middle; stranger: who comes out is another',
        'blind_area': 'hidden from all cameras for 2 to 4 s; turns: comes back out',
        'swapped_kits': 'as one in every image for 1.5 to 3 s, then by any side; scrum: two of '
        'each kit; pair_alike: who cannot be told apart; swapped: some ids as they part are '
        "another's; right: all at last have the id of one of their kit; corrected: published",
    }
