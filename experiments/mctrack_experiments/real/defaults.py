"""What defaults lack: each data set by defaults, beside settings that were tuned on it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from mctrack_experiments.real.stored.detections import (
    DATA_SETS,
    DISTURBANCE_M,
    Settings,
    StoredSet,
)
from mctrack_ros.evaluation.figures import Figures

Progress = Callable[[int, int], None]
Score = tuple[float, float]
"""MOTA and IDF1."""

CHOICES: Mapping[str, Sequence[float | str]] = {
    'association.false_density': (0.01, 0.02, 0.05),
    'association.gate': (9.2, 18.4),
    'motion.sensor_sigma': (0.05, 0.07, 0.1),
    'motion.model': ('interacting',),
    'management.hit_evidence': (1.5, 3.0),
    'management.coverage_prior': (0.1, 0.5, 0.9),
    'management.coverage_cell': (0.5, 1.0),
}
"""What is tried beside the default: what somebody who installs a site might turn."""
SEARCH_SEEDS, SEEDS = (0, 1, 2), (0, *range(11, 19))
"""Disturbances that settings are chosen on, and those that tell what they are worth; 0: none."""
DEFAULT, TUNED, LEFT_OUT = 'default', 'tuned', 'left_out'
FIGURES = ('mota', 'idf1')
WITHIN = {'mota': 0.01, 'idf1': 0.02}
"""By how much tuned settings may be better than defaults."""
HELD = ('lab6p', 'pets', 'cmc1', 'cmc2')
"""Data sets that this is asked of."""
TITLES = {
    'lab6p': 'lab6p',
    'pets': 'PETS, six views',
    'cmc1': 'CMC1',
    'cmc2': 'CMC2',
    'wildtrack': 'WILDTRACK',
    'wildtrack_boxes': 'WILDTRACK, annotated boxes',
}


@dataclass(eq=False, slots=True)
class Search:
    """
    Settings tried on one data set; nothing is tried twice.

    Attributes
    ----------
    data_set : StoredSet
        What they are tried on.
    tried : dict
        MOTA and IDF1 by settings and seed of the disturbance.

    """

    data_set: StoredSet
    tried: dict[tuple[frozenset[tuple[str, float | str]], int], Score] = field(
        default_factory=dict
    )

    def score(self, settings: Settings, seed: int) -> Score:
        """Return MOTA and IDF1 of one run."""
        key = frozenset(settings.items()), seed
        if key not in self.tried:
            moved = self.data_set.disturbed(seed) if seed else self.data_set
            scores = moved.scores(moved.tracks(settings))
            self.tried[key] = scores.mota, scores.idf1
        return self.tried[key]

    def worth(self, settings: Settings) -> float:
        """Return the mean of MOTA and IDF1 over the disturbances of the search."""
        return float(np.mean([self.score(settings, seed) for seed in SEARCH_SEEDS]))

    def tuned(self) -> Settings:
        """Return the best settings: single choices by their gain, each kept if it adds some."""
        best: Settings = {}
        for single in sorted(singles(), key=self.worth, reverse=True):
            (name, _), *_ = single.items()
            if name not in best:
                best = max(best, {**best, **single}, key=self.worth)
        return best


def singles() -> Iterator[Settings]:
    """Yield the settings that differ from the defaults in one value."""
    for name, values in CHOICES.items():
        for value in values:
            yield {name: value}


def reproduce_defaults(data: Path, progress: Progress = lambda done, total: None) -> Figures:
    """
    Score every data set by defaults, by settings tuned on it, and by those that suit the others.

    Parameters
    ----------
    data : Path
        Folder of the real data.
    progress : callable
        Told how many steps are done, of how many.

    """
    searches = {name: Search(open_set(data)) for name, open_set in DATA_SETS.items()}
    tuned: dict[str, Settings] = {}
    for name, search in searches.items():
        progress(len(tuned), 3 * len(searches))
        tuned[name] = search.tuned()
    others: dict[str, Settings] = {}
    for name in searches:
        progress(len(searches) + len(others), 3 * len(searches))
        others[name] = suits_others(name, searches, tuned)
    figures: dict[str, float] = {}
    for done, (name, search) in enumerate(searches.items()):
        progress(2 * len(searches) + done, 3 * len(searches))
        kinds = {DEFAULT: {}, TUNED: tuned[name], LEFT_OUT: others[name]}
        for kind, settings in kinds.items():
            figures |= _figures(f'{name}.{kind}', [search.score(settings, s) for s in SEEDS])
        for figure in FIGURES:
            lost = figures[f'{name}.{TUNED}.{figure}'] - figures[f'{name}.{DEFAULT}.{figure}']
            figures[f'{name}.lost.{figure}'] = lost
    progress(3 * len(searches), 3 * len(searches))
    protocol = {
        'figures': f'mean of {len(SEEDS)} runs, as recorded and with every detection moved by '
        f'{DISTURBANCE_M:g} m at random; recorded: the run of the detections as they are; '
        'gates and frames as in the reproduction of each',
        DEFAULT: 'package defaults; stated are calibration, rate and what a detection means',
        TUNED: 'on these very scores, so no user could: single choices in the order of their '
        f'gain, kept if they add some to the mean of MOTA and IDF1 over {len(SEARCH_SEEDS)} runs '
        'with other disturbances',
        LEFT_OUT: 'the best on all other data sets of: defaults, every single choice, what was '
        'tuned on each of them',
        'choices': {name: list(values) for name, values in CHOICES.items()},
        'settings': {
            name: {TUNED: dict(tuned[name]), LEFT_OUT: dict(others[name])} for name in searches
        },
    }
    return Figures('defaults', 'mctrack reproduce defaults', protocol, figures)


def suits_others(
    name: str, searches: Mapping[str, Search], tuned: Mapping[str, Settings]
) -> Settings:
    """Return the settings that are best on all data sets but one."""
    others = [other for other in searches if other != name]
    candidates: list[Settings] = [{}, *singles(), *(tuned[other] for other in others)]

    def worth(settings: Settings) -> float:
        return sum(searches[other].worth(settings) for other in others)

    return max(candidates, key=worth)


def defaults_table(figures: Figures) -> list[str]:
    """Return the table of default and tuned figures, Markdown, a line each."""
    lines = [
        '| data set | MOTA / IDF1 by default | as recorded | tuned on it (‡) | as recorded (‡) '
        '| chosen on the others | tuned settings (‡) | within .01 / .02 |',
        '| --- | --- | --- | --- | --- | --- | --- | --- |',
    ]
    for name, title in TITLES.items():

        def pair(kind: str, prefix: str = '', name: str = name) -> str:
            values = (figures.figures[f'{name}.{kind}.{prefix}{figure}'] for figure in FIGURES)
            return ' / '.join(f'{value:.3f}' for value in values)

        lost = {figure: figures.figures[f'{name}.lost.{figure}'] for figure in FIGURES}
        is_within = all(round(value, 3) <= WITHIN[figure] for figure, value in lost.items())
        verdict = 'yes' if is_within else '**no**' if name in HELD else 'no'
        settings = figures.protocol['settings'][name][TUNED].items()
        cells = (
            title,
            pair(DEFAULT),
            pair(DEFAULT, 'recorded.'),
            pair(TUNED),
            pair(TUNED, 'recorded.'),
            pair(LEFT_OUT),
            ', '.join(f'`{key}` {value}' for key, value in settings),
            verdict,
        )
        lines.append(f'| {" | ".join(cells)} |')
    return lines


def _figures(prefix: str, scores: Sequence[Score]) -> dict[str, float]:
    """Return means and deviations over runs, and the first run, of detections as they are."""
    figures = {}
    for name, values in zip(FIGURES, np.transpose(scores)):
        figures[f'{prefix}.{name}'] = float(np.mean(values))
        figures[f'{prefix}.{name}_deviation'] = float(np.std(values, ddof=1))
        figures[f'{prefix}.recorded.{name}'] = float(values[0])
    return figures
