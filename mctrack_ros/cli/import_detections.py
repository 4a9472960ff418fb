"""`mctrack import-detections`: what somebody's own detectors saw, into a bag."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from mctrack_ros.interfaces import ClassCode
    from mctrack_ros.recording.box_files import TextClock
    from mctrack_ros.recording.sightings import Sightings
    from mctrack_ros.replay.import_detections import Imported

_BAGS = ('.mcap', '.db3')
_LARGEST_SCORE = 1e9


def import_detections(
    out: Path = typer.Argument(..., help='The bag to write.'),
    sources: list[str] = typer.Argument(
        ...,
        help='camera=file: MOT text, a CSV with a header, or a bag with '
        'vision_msgs/Detection2DArray (camera=bag:/topic if it holds several).',
    ),
    site: str = typer.Option(..., help='Site YAML, or the name of a shipped site.'),
    rate: float = typer.Option(
        0.0, min=0.0, max=1000.0, help='Pictures a second: of files that count frames.'
    ),
    first_frame: int = typer.Option(
        1, min=0, help='Number of the first picture, of files that count frames.'
    ),
    later: list[str] = typer.Option(
        [], help='camera=seconds, for a text whose first picture came so long after the first.'
    ),
    score_range: str = typer.Option(
        '0,1', help='LOW,HIGH: the scores of the texts that stand for 0 and for 1.'
    ),
    least_score: float = typer.Option(
        0.0, min=0.0, max=1.0, help='Leave out what has a lower score, after --score-range.'
    ),
    classes: list[str] = typer.Option(
        [],
        '--class',
        help="The detector's own name or number of a class, and what it is: car=vehicle, "
        '0=person; one of person, vehicle, bicycle, ball, unknown.',
    ),
    overwrite: bool = typer.Option(False, '--overwrite', help='Replace an earlier bag.'),
) -> None:
    """Put the boxes or positions of your own detectors into a bag, for `mctrack track`."""
    from mctrack_ros.cli.progress import progress_bar
    from mctrack_ros.cli.sites import named_site
    from mctrack_ros.cli.videos import by_camera, seconds_of
    from mctrack_ros.recording.box_files import TextClock
    from mctrack_ros.recording.class_names import CLASS_NAMES
    from mctrack_ros.recording.sightings import with_all_pictures
    from mctrack_ros.replay import import_detections as importing

    config = named_site(site)
    files = by_camera(sources, 'north=north.txt')
    delays = {name: seconds_of(text) for name, text in by_camera(later, 'south=1.5').items()}
    for name in delays.keys() - files.keys():
        raise ValueError(f'--later names {name}, expected one of {", ".join(files)}')
    limits = _limits(score_range)
    sightings = {
        name: _read(name, source, TextClock(rate, first_frame, delays.get(name, 0.0), limits))
        for name, source in files.items()
    }
    known = {**CLASS_NAMES, **_classes(classes)}
    with progress_bar('importing') as progress:
        done = importing.import_detections(
            with_all_pictures(sightings),
            config,
            out,
            classes=known,
            least_score=least_score,
            overwrite=overwrite,
            progress=progress,
        )
    for name, imported in done.items():
        camera = config.cameras[name]
        size = camera.image_width, camera.image_height
        for line in _report(name, imported, size):
            typer.echo(line)
        if sightings[name].unused:
            typer.echo(f'{name}: columns not read: {", ".join(sightings[name].unused)}')
    for name in sorted(config.cameras.keys() - files.keys()):
        typer.echo(
            f'{name} of {config.name} is not in the bag: `mctrack track` wants a site without it',
            err=True,
        )
    typer.echo(f'wrote {out}')


def _read(name: str, source: str, clock: TextClock) -> Sightings:
    """Read a text, or a bag (and its topic behind a colon)."""
    from mctrack_ros.recording.box_files import read_boxes
    from mctrack_ros.recording.vision_messages import read_detection_arrays

    path, colon, topic = source.rpartition(':/')
    if not colon:
        path, topic = source, ''
    if Path(path).is_dir() or Path(path).suffix in _BAGS:
        if clock.later_s:
            raise ValueError(f'{source} has stamps of its own: --later cannot move them')
        return read_detection_arrays(path, name, f'/{topic}' if colon else '')
    return read_boxes(source, clock)


def _limits(text: str) -> tuple[float, float]:
    try:
        low, high = (float(number) for number in text.split(','))
    except ValueError:
        low = high = 0.0
    if not -_LARGEST_SCORE < low < high < _LARGEST_SCORE:
        raise ValueError(f'--score-range is {text!r}, expected LOW,HIGH, for example 0,100')
    return low, high


def _classes(texts: list[str]) -> Mapping[str, ClassCode]:
    from mctrack_ros.interfaces import ClassCode

    codes = {code.name.lower(): code for code in ClassCode}
    found = {}
    for text in texts:
        name, _, wanted = text.partition('=')
        if not name or wanted not in codes:
            raise ValueError(
                f'--class has {text!r}, expected a name and one of {", ".join(codes)}: car=vehicle'
            )
        found[name.lower()] = codes[wanted]
    return found


def _report(name: str, imported: Imported, site_size: tuple[int, int]) -> Iterator[str]:
    """Yield what is to be said of a camera: what was left out is never silent."""
    yield (
        f'{name}: {imported.written} detections of {imported.rows} in {imported.pictures} '
        f'pictures, {imported.empty} of them empty'
    )
    width, height = site_size
    for count, what in (
        (imported.doubtful, 'left out, their score is below --least-score'),
        (imported.no_ground, 'left out, their feet are not on ground that the camera sees'),
        (
            imported.outside,
            f'left out, outside the picture (are they of pictures of {width} x {height} px?)',
        ),
        (imported.extrapolated, 'beyond the points of the calibration: kept, less certain'),
    ):
        if count:
            yield f'{name}: {count} {what}'
    for label, count in sorted(imported.classes.items()):
        yield f'{name}: {count} of class {label} left out (--class {label}=person?)'
