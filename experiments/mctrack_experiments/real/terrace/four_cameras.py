"""EPFL terrace, real images with truth: four cameras at 3 Hz, and two videos at 25 Hz."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from mctrack_experiments.datasets.epfl_terrace import (
    AREA,
    CAMERAS,
    CUT_OFF_PX,
    PERIOD_NS,
    SIZE,
    image_files,
    metres_from_top_view,
    read_identities,
    read_positions,
    write_calibration,
)
from mctrack_experiments.datasets.stored import inside
from mctrack_experiments.real.foreground.places_left import places_left
from mctrack_experiments.real.terrace import videos as terrace
from mctrack_experiments.runs import medians
from mctrack_experiments.targets import TARGETS
from mctrack_ros.codec import compressed_message
from mctrack_ros.evaluation import Trajectories
from mctrack_ros.evaluation.clear_mot import clear_mot, detection_scores
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.evaluation.frames import frames_of, ground_distance, matched
from mctrack_ros.interfaces import Foreground
from mctrack_ros.recording import ROSBAGS_CLASSES, BagReader, BagWriter
from mctrack_ros.recording.tracks.track_table import read_track_table
from mctrack_ros.recording.video.videos import START_NS, open_video
from mctrack_ros.replay.track import track_bag
from mctrack_ros.site.site import SiteConfig, load_site

POSITION_GATES_M = {'': 1.0, 'gate_half_metre.': 0.5}
IDENTITY_GATE_M = 1.0
IDENTITY_FIGURES = ('mota', 'idf1', 'switches', 'false_positives', 'misses')
TUNED_TO, LAST = 1250, 2500
"""Last frame that parameters may be chosen on, and last of all."""
IMAGES_S = 0.2
"""How far apart images of the four cameras are at least, s."""
TRACKERS = {'': '', 'joint.': 'joint'}
"""Trackers of fusion for the four cameras, by the prefix of their figures; empty: by default."""
FIRST_IMAGE, FIRST_OF_VIDEO = 75, 100
"""First frames that are scored: before, backgrounds are learned."""


def reproduce_terrace4(
    data: Path, runs: int = 1, progress: Callable[[int, int], None] = lambda done, total: None
) -> Figures:
    """
    Track the images of four cameras by either tracker and compare with both truths.

    Parameters
    ----------
    data : Path
        Folder of the real data.
    runs : int
        So many; run k leaves out the first k images of each camera. Figures are medians.
    progress : callable
        Told how many runs are done, of how many.

    """
    measured = []
    for run in range(runs):
        progress(run, runs)
        measured.append(_terrace4_run(data, run))
    progress(runs, runs)
    spread = {target.figure for target in TARGETS if target.experiment == 'terrace4'}
    protocol = dict(measured[0].protocol)
    if runs > 1:
        protocol['runs'] = (
            f'{runs}: run k, from 0, begins k images later, and the messages of an instant arrive '
            'in an order of its own. That order changes nothing, since a tick sorts its cameras, '
            'and nothing is random; a recording that begins later is what differs in the field. '
            'Figures are medians, each by itself; least, most: of the runs'
        )
    figures = medians([each.figures for each in measured], spread if runs > 1 else ())
    command = measured[0].command + (f' --repeat {runs}' if runs > 1 else '')
    return Figures('terrace4', command, protocol, figures)


def _terrace4_run(data: Path, run: int) -> Figures:
    """Track once, without the first images."""
    tracks = {}
    with tempfile.TemporaryDirectory(prefix='mctrack_terrace_') as name:
        folder = Path(name)
        write_images(data, folder / 'bag', run)
        for prefix, tracker in TRACKERS.items():
            site = write_site(data, folder, tracker)
            out = folder / f'out{tracker}'
            track_bag(folder / 'bag', out, site)
            tracks[f'terrace4.{prefix}'] = read_tracks(out, 0)
        shares = places_left(
            folder / 'out' / 'bag', site.views().mappings, read_identities(data), START_NS
        )
        shares['mask_bytes'] = _mask_bytes(folder / 'out' / 'bag')
    frames = [frame for frame in image_files(data, CAMERAS[0]) if frame >= FIRST_IMAGE]
    protocol = {
        'data': '300 images of each of four cameras, 360 x 288 px, 0.2 to 0.4 s apart',
        'frames': f'the images among {FIRST_IMAGE}-{LAST}',
        'settings': 'calibration after Tsai, size of the images, ticks of their shortest '
        f'distance, {IMAGES_S:g} s, and feedback of two ticks before; all else by default',
        'joint': 'the same with fusion.tracker joint; the default here is occupancy, whose '
        f'parameters and constants were chosen on frames up to {TUNED_TO}; of the bins and the '
        'weight of colours, those after were seen, too',
        'foreground': "share of foreground in people's boxes at places where nobody has been "
        '(never), or whom the last person left 0.5 to 5 s ago (just_left), 20 to 60 s ago (left); '
        "boxes that a person's overlaps do not count; mask_bytes: mean size of the masks' PNG",
    }
    figures = _figures('terrace4', protocol, data, tracks, CAMERAS, frames)
    named = {f'terrace4.foreground.{name}': share for name, share in shares.items()}
    return replace(figures, figures=dict(figures.figures) | named)


def _mask_bytes(bag: Path) -> float:
    """Return the mean size of the masks that the cameras publish, bytes."""
    with BagReader(bag) as reader:
        topics = [f'/{camera}/{Foreground.TOPIC}' for camera in CAMERAS]
        return float(np.mean([len(message.data) for _, message, _ in reader.messages(topics)]))


def reproduce_terrace(data: Path) -> Figures:
    """Track both videos and compare with both truths."""
    with tempfile.TemporaryDirectory(prefix='mctrack_terrace_') as name:
        folder = Path(name)
        videos = {camera: open_video(terrace.video(data, camera)) for camera in terrace.CAMERAS}
        track_bag(videos, folder / 'out', terrace.write_site(data, folder))
        tracks = read_tracks(folder / 'out', 1)
    top_view_px = tracks.position / terrace.METRES_PER_TOP_VIEW_PX
    tracks = replace(tracks, position=metres_from_top_view(top_view_px))
    frames = range(FIRST_OF_VIDEO, LAST + 1)
    protocol = {
        'data': 'two videos, 360 x 288 px, 25 images a second',
        'frames': f'{FIRST_OF_VIDEO}-{LAST}',
        'settings': 'homographies, size of the images, a mask over the watermark, as in the live '
        'run; all else by default',
    }
    return _figures('terrace', protocol, data, {'terrace.': tracks}, terrace.CAMERAS, frames)


def write_site(data: Path, folder: Path, tracker: str = '') -> SiteConfig:
    """
    Write the site of the four cameras into a folder and read it.

    It says what everybody has to say of cameras: calibrations, sizes and how fast they are.

    Parameters
    ----------
    data : Path
        Folder of the real data.
    folder : Path
        Where calibrations and site go.
    tracker : str
        Of fusion; empty: none is named.

    """
    cameras = {}
    for camera in CAMERAS:
        write_calibration(data, camera, folder / f'{camera}.xml')
        cameras[camera] = {
            'calibration': f'{camera}.xml',
            'image_width': SIZE[0],
            'image_height': SIZE[1],
        }
    site = {
        'name': 'terrace',
        'cameras': cameras,
        'feedback_delay': 2 * IMAGES_S,
        'fusion': {'batching': {'period': IMAGES_S}} | ({'tracker': tracker} if tracker else {}),
    }
    (folder / 'site.yaml').write_text(yaml.safe_dump(site))
    return load_site(folder / 'site.yaml')


def write_images(data: Path, bag: Path, run: int = 0) -> None:
    """
    Write the images of all cameras into a bag, stamped with the middles of their frames.

    Parameters
    ----------
    data : Path
        Folder of the real data.
    bag : Path
        To be written.
    run : int
        So many first images of each camera are left out; also the seed of the order in which
        the images of an instant arrive, by camera in run 0.

    """
    random = np.random.default_rng(run)
    images = [
        (START_NS + frame * PERIOD_NS + PERIOD_NS // 2, random.random() * bool(run), camera, file)
        for camera in CAMERAS
        for frame, file in list(image_files(data, camera).items())[run:]
    ]
    write_jpegs(bag, ((stamp_ns, camera, file) for stamp_ns, _, camera, file in sorted(images)))


def write_jpegs(bag: Path, images: Iterable[tuple[int, str, Path]]) -> None:
    """Write stamps, ns, cameras and files of images into a bag."""
    with BagWriter(bag) as writer:
        for stamp_ns, camera, file in images:
            jpeg = np.frombuffer(file.read_bytes(), np.uint8)
            frame_id = f'{camera}_optical_frame'
            message = compressed_message(jpeg, ROSBAGS_CLASSES, stamp_ns, frame_id)
            writer.write(f'/{camera}/image_raw/compressed', message, stamp_ns)


def read_tracks(out: Path, first_frame: int) -> Trajectories:
    """
    Read the tracks that `track_bag` wrote.

    Parameters
    ----------
    out : Path
        Its folder.
    first_frame : int
        Number of the frame that begins at `START_NS`.

    """
    instants, _, _ = read_track_table(out / 'tracks.csv', PERIOD_NS)
    return Trajectories.from_tracks(instants, PERIOD_NS, START_NS - first_frame * PERIOD_NS)


def scored(
    tracks: Trajectories,
    positions: Trajectories,
    identities: Trajectories,
    frames: Sequence[int],
) -> dict[str, float]:
    """
    Compare tracks with both truths.

    Parameters
    ----------
    tracks : Trajectories
        Those outside the annotated area are left out.
    positions, identities : Trajectories
        The truths; frames without positions do not count for these.
    frames : sequence of int
        Which frames count.

    Returns
    -------
    dict
        MODA, MODP, precision and recall at both gates, MOTA, IDF1 and counts, by name.

    """
    tracks = tracks.select(inside(tracks.position, AREA)).at_frames(frames)
    positions = positions.at_frames(frames)
    there = tracks.at_frames(positions.frame)
    figures: dict[str, float] = {}
    for prefix, gate in POSITION_GATES_M.items():
        instants = frames_of(positions, there, 'position', ground_distance, gate)
        hits = sum(len(matched(instant.distance, gate)[0]) for instant in instants)
        scores = detection_scores(instants, gate, gate)
        scores |= {'precision': hits / max(len(there), 1), 'recall': hits / len(positions)}
        figures |= {prefix + name: value for name, value in scores.items()}
    identities = identities.at_frames(frames)
    instants = frames_of(identities, tracks, 'position', ground_distance, IDENTITY_GATE_M)
    with_identity = clear_mot(instants, IDENTITY_GATE_M)
    return figures | {name: with_identity[name] for name in IDENTITY_FIGURES}


def _figures(
    name: str,
    protocol: dict[str, Any],
    data: Path,
    tracks: Mapping[str, Trajectories],
    cameras: Sequence[str],
    frames: Sequence[int],
) -> Figures:
    """Return the scores of all frames and of both parts of them, of tracks by prefix."""
    positions, identities = read_positions(data), read_identities(data, cameras)
    parts = {
        '': frames,
        f'to_{TUNED_TO}.': [frame for frame in frames if frame <= TUNED_TO],
        f'from_{TUNED_TO + 1}.': [frame for frame in frames if frame > TUNED_TO],
    }
    figures = {
        f'{prefix}{part}{figure}': value
        for prefix, own_tracks in tracks.items()
        for part, own in parts.items()
        for figure, value in scored(own_tracks, positions, identities, own).items()
    }
    protocol |= {
        'cameras': list(cameras),
        'area': f'x {AREA[0]}, y {AREA[1]} m',
        'moda, modp, precision, recall': "positions of 3DROM's annotation, on a grid of 0.25 m, "
        'in frames that have any; at 1 m, gate_half_metre: 0.5 m',
        'mota, idf1 and counts': "feet of GNN-CCA's boxes in these cameras, the mean of a "
        f'person, at {IDENTITY_GATE_M:g} m; boxes that are lost or end from row {CUT_OFF_PX} on '
        'do not count; the feet of two cameras are 0.37 to 0.70 m apart, medians by pair',
        'tuning': f'none by these truths; allowed on frames up to {TUNED_TO}',
    }
    return Figures(name, f'mctrack reproduce {name}', protocol, figures)
