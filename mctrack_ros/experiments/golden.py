"""
The golden bag: what five cameras detected in a short match, with truth, and its scores.

``python -m mctrack_ros.experiments.golden bags`` makes it again.
"""

from __future__ import annotations

import sys
import tempfile
from dataclasses import replace
from pathlib import Path

from mctrack_ros.experiments.comparison import compare
from mctrack_ros.experiments.figures import Figures
from mctrack_ros.experiments.simulate import simulate
from mctrack_ros.recording import BagReader, BagWriter
from mctrack_ros.replay.track import track_bag
from mctrack_ros.resources import config_file
from mctrack_ros.simulation import Scenario
from mctrack_ros.site_config import load_site

NAME = 'pitch5_detections'
SCENARIO = Scenario(seed=7, duration_s=6.0)


def write_golden(folder: Path) -> Figures:
    """Simulate, detect, keep the detections and the truth; track those and keep the scores."""
    site = load_site(config_file('pitch5.yaml'))
    golden = folder / NAME
    with tempfile.TemporaryDirectory(prefix='mctrack_golden_') as name:
        scratch = Path(name)
        simulate(SCENARIO, scratch / 'match')
        track_bag(scratch / 'match', scratch / 'tracked', site)
        kept = {
            '/truth/tracks': scratch / 'match',
            **{f'/{camera}/detections': scratch / 'tracked/bag' for camera in site.cameras},
        }
        with BagWriter(golden, overwrite=True) as writer:
            for topic, source in kept.items():
                with BagReader(source) as reader:
                    for item in reader.serialized([topic]):
                        writer.write_copy(reader, *item)
        figures = golden_figures(golden, scratch / 'again')
    figures.write(folder / f'{NAME}.json')
    return figures


def golden_figures(golden: Path, scratch: Path) -> Figures:
    """Track the golden bag's detections and score the tracks against its truth."""
    site = load_site(config_file('pitch5.yaml'))
    track_bag(golden, scratch, site, processes=1)
    figures = compare(golden, scratch / 'bag', 1.0)
    return replace(figures, command='python -m mctrack_ros.experiments.golden bags')


if __name__ == '__main__':
    print(write_golden(Path(sys.argv[1])).table())
