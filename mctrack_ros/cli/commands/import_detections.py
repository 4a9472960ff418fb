"""`mctrack import-detections`: what somebody's own detectors saw, into a bag."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from mctrack_ros.cli.commands.videos import by_camera, by_known_camera, delays_of

if TYPE_CHECKING:
    from mctrack_ros.interfaces import ClassCode
    from mctrack_ros.recording.tables.box_files import TextClock
    from mctrack_ros.recording.tables.sightings import Sightings
    from mctrack_ros.replay.detections.import_detections import Imported

_BAGS = ('.mcap', '.db3')
_LARGEST_SCORE = 1e9
_MOST_FRAMES = 2**32
_FIRST_FRAME, _SCORE_RANGE = '1', '0,1'


def import_detections(
    out: Path = typer.Argument(..., help='The bag to write.'),
    sources: list[str] = typer.Argument(
        ...,
        help='camera=file: MOT text, a CSV with a header, or a bag with '
        'vision_msgs/Detection2DArray (camera=bag:/topic if it holds several).',
    ),
    site: str = typer.Option(..., help='Site YAML, or the name of a shipped site.'),
    rate: float = typer.Option(
        0.0, min=0.0, max=1000.0, help='Images a second, for files that count frames.'
    ),
    first_frame: list[str] = typer.Option(
        [_FIRST_FRAME],
        help='First frame number of files that count frames; camera=number for one.',
    ),
    later: list[str] = typer.Option(
        [], help='camera=seconds: the first image of this text came so much later.'
    ),
    score_range: list[str] = typer.Option(
        [_SCORE_RANGE],
        help='LOW,HIGH: scores in the texts that mean 0 and 1; camera=LOW,HIGH for one.',
    ),
    least_score: float = typer.Option(
        0.0, min=0.0, max=1.0, help='Leave out lower scores, after --score-range.'
    ),
    images: Path | None = typer.Option(
        None,
        help='Bag with the images of cameras that move (pipeline.moving): their calibration is '
        'followed in them.',
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
    from mctrack_ros.cli.sites import camera_site
    from mctrack_ros.recording.tables.class_names import CLASS_NAMES
    from mctrack_ros.recording.tables.sightings import with_all_images
    from mctrack_ros.replay.detections import import_detections as importing

    config = camera_site(site)
    files = by_camera(sources, 'north=north.txt')
    clocks = _clocks(files, rate, first_frame, later, score_range)
    sightings = {name: _read(name, source, clocks[name]) for name, source in files.items()}
    with progress_bar('importing') as progress:
        done = importing.import_detections(
            with_all_images(sightings),
            config,
            out,
            images=images,
            classes={**CLASS_NAMES, **_classes(classes)},
            least_score=least_score,
            overwrite=overwrite,
            progress=progress,
        )
    for name, imported in done.items():
        for line in _report(name, imported, config.image_sizes[name]):
            typer.echo(line)
        if sightings[name].unused:
            typer.echo(f'{name}: columns not read: {", ".join(sightings[name].unused)}')
    for name in sorted(config.cameras.keys() - files.keys()):
        typer.echo(
            f'{name} of {config.name} is not in the bag: `mctrack track` wants a site without it',
            err=True,
        )
    typer.echo(f'wrote {out}')


def _clocks(
    files: Mapping[str, str],
    rate: float,
    first_frame: list[str],
    later: list[str],
    score_range: list[str],
) -> dict[str, TextClock]:
    """Return what the options say of the text of each camera."""
    from mctrack_ros.recording.tables.box_files import TextClock

    delays = delays_of(later, files)
    first = _of_each('--first-frame', first_frame, _FIRST_FRAME, files)
    limits = _of_each('--score-range', score_range, _SCORE_RANGE, files)
    return {
        name: TextClock(rate, _frame(first[name]), delays.get(name, 0.0), _limits(limits[name]))
        for name in files
    }


def _of_each(
    option: str, texts: list[str], usual: str, files: Mapping[str, str]
) -> dict[str, str]:
    """Return an option's values by camera; one without a camera holds for all others."""
    plain = [text for text in texts if '=' not in text]
    if len(plain) > 1:
        raise ValueError(f'{option} is given twice without a camera: {", ".join(plain)}')
    named = [text for text in texts if '=' in text]
    stated = by_known_camera(option, named, f'north={usual}', files)
    for name in stated:
        if _is_bag(files[name]):
            raise ValueError(f'{files[name]} is a bag: {option} is for texts')
    return dict.fromkeys(files, *(plain or [usual])) | stated


def _read(name: str, source: str, clock: TextClock) -> Sightings:
    """Read a text, or a bag (and its topic behind a colon)."""
    from mctrack_ros.recording.tables.box_files import read_boxes
    from mctrack_ros.recording.tables.vision_messages import read_detection_arrays

    if not _is_bag(source):
        return read_boxes(source, clock)
    if clock.later_s:
        raise ValueError(f'{source} has stamps of its own: --later cannot move them')
    path, topic = _bag_and_topic(source)
    return read_detection_arrays(path, name, topic)


def _is_bag(source: str) -> bool:
    path = Path(_bag_and_topic(source)[0])
    return path.is_dir() or path.suffix in _BAGS


def _bag_and_topic(source: str) -> tuple[str, str]:
    """Return the path and the topic behind the colon; empty if none is named."""
    path, colon, topic = source.rpartition(':/')
    return (path, f'/{topic}') if colon else (source, '')


def _frame(text: str) -> int:
    if not (text.isdecimal() and int(text) < _MOST_FRAMES):
        raise ValueError(f'--first-frame is {text!r}, expected a whole number, 0 or more')
    return int(text)


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
    """Yield the lines to print about a camera, each row left out included."""
    yield (
        f'{name}: {imported.written} detections of {imported.rows} in {imported.images} '
        f'images, {imported.empty} of them empty'
    )
    width, height = site_size
    for count, what in (
        (imported.doubtful, 'left out, their score is below --least-score'),
        (imported.no_ground, 'left out, their feet are not on ground that the camera sees'),
        (
            imported.outside,
            f'left out, outside the image (are they of images of {width} x {height} px?)',
        ),
        (imported.extrapolated, 'beyond the points of the calibration: kept, less certain'),
    ):
        if count:
            yield f'{name}: {count} {what}'
    if imported.lost:
        yield f'{name}: {imported.lost} images left out: it is not known how the camera looked'
    for label, count in sorted(imported.classes.items()):
        yield f'{name}: {count} of class {label} left out (--class {label}=person?)'
