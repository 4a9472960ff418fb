"""TUD-Stadtmitte: one low camera on a street, people everywhere from the first image on."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path

import numpy as np
import yaml

from mctrack_experiments.datasets.epfl_terrace import PERIOD_NS
from mctrack_experiments.real.terrace.four_cameras import read_tracks, write_jpegs
from mctrack_ros.evaluation import Trajectories, evaluate_ground
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.recording.video.videos import START_NS
from mctrack_ros.replay.track import track_bag
from mctrack_ros.site.site import SiteConfig, load_site

FOLDER, SIZE, GATE_M = 'tud_stadtmitte', (640, 480), 1.0


def reproduce_street(data: Path) -> Figures:
    """Track the clip as `mctrack track` does and compare with the truth on the ground."""
    files = sorted((data / FOLDER / 'img1').glob('*.jpg'))
    with tempfile.TemporaryDirectory(prefix='mctrack_street_') as name:
        folder = Path(name)
        stamps = (START_NS + (2 * (int(file.stem) - 1) + 1) * PERIOD_NS // 2 for file in files)
        write_jpegs(folder / 'bag', ((at, 'street', file) for at, file in zip(stamps, files)))
        track_bag(folder / 'bag', folder / 'out', write_site(data, folder))
        tracks = read_tracks(folder / 'out', 1)
    scores = evaluate_ground(read_truth(data), tracks, GATE_M)
    figures: dict[str, float] = {
        'street.moda': scores.moda,
        'street.mota': scores.mota,
        'street.idf1': scores.idf1,
        'street.hota': scores.hota,
        'street.switches': scores.switches,
        'street.precision': scores.precision,
        'street.recall': scores.recall,
        'street.error_m': scores.mean_distance,
    }
    protocol = {
        'data': f'TUD-Stadtmitte, {len(files)} images of {SIZE[0]} x {SIZE[1]} px, 25 a second',
        'frames': 'all',
        'gate': f'{GATE_M:g} m on the ground, by the homography of the data',
        'settings': 'defaults; stated are homography and size of the images',
    }
    return Figures('street', 'mctrack reproduce street', protocol, figures)


def read_truth(data: Path) -> Trajectories:
    """Read where everybody is, m."""
    table = np.loadtxt(data / FOLDER / 'gt' / 'gt.txt', delimiter=',')
    return Trajectories(table[:, 0].astype(int), table[:, 1].astype(int), table[:, 7:9])


def write_site(data: Path, folder: Path) -> SiteConfig:
    """Write the site of the camera into a folder and read it."""
    stored = json.loads((data / FOLDER / 'ground_H.json').read_text())
    calibration = {'ground_from_image': stored['feet_px_to_world_m']}
    (folder / 'street.yaml').write_text(yaml.safe_dump(calibration))
    size = {'image_width': SIZE[0], 'image_height': SIZE[1]}
    site = {'name': 'street', 'cameras': {'street': {'calibration': 'street.yaml', **size}}}
    (folder / 'site.yaml').write_text(yaml.safe_dump(site))
    return load_site(folder / 'site.yaml')
