"""Commands that need no ROS: simulate, track, background, echo."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from mctrack_ros.cli.commands.videos import LATER, RATE, open_videos, warn
from mctrack_ros.processes import prepare_workers
from mctrack_ros.site.names import namespace_of, resolved

if TYPE_CHECKING:
    from mctrack_ros.evaluation.figures import Figures
    from mctrack_ros.recording.video.videos import Video
    from mctrack_ros.replay.camera_source import CameraTask
    from mctrack_ros.replay.track import TrackSummary
    from mctrack_ros.site.site import SiteConfig

_TABLE_WIDTH = 10_000  # rows are not broken; a terminal or `less -S` does what it does
_USUAL_SITE = 'pitch5'
_OVERWRITE = typer.Option(False, '--overwrite', help='Replace earlier results.')
_PROCESSES = typer.Option(2, min=1, max=64, help='Processes to share the cameras among.')
_WORKERS = typer.Option(
    None, min=1, max=64, help='Processes to share the cameras among; unless given, one a camera.'
)


class SceneName(StrEnum):
    """What can be simulated."""

    PITCH5 = 'pitch5'
    PTZ = 'ptz'
    CARPARK = 'carpark'
    INDOOR = 'indoor'
    GREY_CARPARK = 'grey_carpark'
    HALL = 'hall'


_OF_ONE_SCENE = {
    'bicycles': (SceneName.CARPARK, 'bicycles come'),
    'follows_play': (SceneName.PTZ, 'cameras follow the play'),
    'people': (SceneName.INDOOR, 'people are counted'),
}
"""Options that belong to one scene, and what they do."""


def simulate(
    out: Path = typer.Argument(..., help='The bag to write.'),
    scene: SceneName = typer.Option(
        SceneName.PITCH5,
        help='Five cameras around a football pitch, two beside it that pan, tilt and zoom, '
        'one over a car park, four in a room, around a grey car park, or in a hall with one door.',
    ),
    seconds: float | None = typer.Option(
        None,
        min=0.04,
        help='Length, s; unless given, 120 of the match, 600 of the car park, 23.6 of the room, '
        '60 of the grey car park, 55 of the hall.',
    ),
    seed: int = typer.Option(1, min=0, help='Seed; the same seed gives the same bytes.'),
    cameras: int | None = typer.Option(None, min=1, max=5, help='How many of the cameras.'),
    noise: float | None = typer.Option(
        None, min=0.1, max=50.0, help='Sensor noise, grey levels; pitch5: 2, carpark: 2.6.'
    ),
    shadows: bool | None = typer.Option(
        None,
        '--shadows/--no-shadows',
        help='Whether to draw shadows; by default only on car parks and in the hall.',
    ),
    distortion: float | None = typer.Option(
        None, min=-0.5, max=0.5, help='First radial coefficient of the lenses; indoor: -0.05.'
    ),
    lighting_drift: float | None = typer.Option(
        None, min=0.0, max=0.9, help='Amplitude of a slow change of brightness; carpark: 0.06.'
    ),
    light_step: float = typer.Option(
        0.0, min=-0.9, max=2.0, help='Change of the light at --step-at, as a share.'
    ),
    gain_step: float = typer.Option(
        0.0, min=-0.9, max=2.0, help="Change of the camera's gain at --step-at, as a share."
    ),
    step_at: float | None = typer.Option(
        None, min=0.0, help='When light or gain change, s; unless given, 20, indoor: 12.'
    ),
    people: int | None = typer.Option(None, min=1, max=6, help='How many, indoor; else 4.'),
    bicycles: bool = typer.Option(
        False, '--bicycles', help='Also let bicycles ride through the car park.'
    ),
    follow_play: bool = typer.Option(
        False,
        '--follow-play',
        help='ptz: let the cameras follow the ball, not paths of their own.',
    ),
    processes: int = _PROCESSES,
    overwrite: bool = _OVERWRITE,
    calibration: Path | None = typer.Option(
        None, help='Also write scene and transformation grids into this folder.'
    ),
    json_file: Path | None = typer.Option(None, '--json', help='Also write the difficulty here.'),
) -> None:
    """Render the five-camera football pitch, a car park or a room, with truth, into a bag."""
    from mctrack_ros.cli.progress import progress_bar
    from mctrack_ros.cli.tables import show_figures
    from mctrack_ros.evaluation.figures import Figures
    from mctrack_ros.simulation import calibration as calibration_files
    from mctrack_ros.simulation import recording as rendering

    given: dict[str, Any] = {
        'duration_s': seconds,
        'distortion': distortion,
        'cameras': cameras,
        'noise': noise,
        'shadows': shadows,
        'lighting_drift': lighting_drift,
        'light_step': light_step,
        'gain_step': gain_step,
        'step_s': step_at,
        'bicycles': bicycles or None,
        'follows_play': follow_play or None,
        'people': people,
    }
    scenario = _scenario(scene, seed, given)
    if calibration is not None:
        calibration_files.write_calibration(scenario, calibration)
    with progress_bar('rendering') as progress:
        difficulty = rendering.simulate(
            scenario, out, processes=processes, overwrite=overwrite, progress=progress
        )
    choice = '' if scene is SceneName.PITCH5 else f' --scene {scene}'
    choice += ' --bicycles' * bicycles + ' --follow-play' * follow_play
    length = f'--seconds {scenario.duration_s:g} --seed {seed}'
    figures = Figures(
        name='simulate' if scene is SceneName.PITCH5 else f'simulate_{scene}',
        command=f'mctrack simulate {out.name}{choice} {length}',
        protocol=asdict(scenario),
        figures=difficulty.figures(),
    )
    show_figures(figures, json_file)
    typer.echo(f'wrote {out}')


def _scenario(scene: SceneName, seed: int, given: Mapping[str, Any]) -> Any:
    """Return the scenario of a scene with what is given; `typer.BadParameter`: of another one."""
    from mctrack_ros.simulation import SCENES

    options = {name: value for name, value in given.items() if value is not None}
    for name, (only, what) in _OF_ONE_SCENE.items():
        if name in options and scene is not only:
            raise typer.BadParameter(f'{what} with --scene {only} only')
    return SCENES[scene].scenario(seed=seed, **options)


def track(
    sources: list[str] = typer.Argument(
        ...,
        metavar='BAG | CAMERA=VIDEO...',
        help='Bag with the images, or detections, of every camera; or the video file of each, '
        'for example north=north.mp4 south=south.mp4.',
    ),
    out: Path | None = typer.Option(
        None, help='Folder for the bag of results, tracks.txt and tracks.csv; must be given.'
    ),
    site: str = typer.Option(
        '', help=f'Site YAML, or the name of a shipped site; unless given, {_USUAL_SITE}.'
    ),
    namespace: str = typer.Option(
        '', callback=namespace_of, help='Namespace of the cameras in the bag.'
    ),
    later: list[str] = LATER,
    rate: float = RATE,
    processes: int | None = _WORKERS,
    overwrite: bool = _OVERWRITE,
    explain: bool = typer.Option(
        False, '--explain', help='Also write the explanations of each tick.'
    ),
    log_times: bool = typer.Option(
        False, '--log-times', help='Use the times of recording instead of the stamps of a bag.'
    ),
    debug_images: Path | None = typer.Option(
        None, help='Folder for images with boxes, ids, groups and predictions, by camera.'
    ),
    debug_every: float = typer.Option(1.0, min=0.0, help='Time between these, s; 0: all.'),
    store: str = typer.Option(
        '',
        help='Also write tracks and events into this trajectory database: a file, made unless it '
        'is there, or a URL such as postgresql://user@host/name.',
    ),
    run: str = typer.Option(
        '',
        help='What the run is called in the database; by default as the folder of --out, with a '
        'number behind it if that is taken.',
    ),
    json_file: Path | None = typer.Option(None, '--json', help='Also write the figures here.'),
) -> None:
    """Track a bag, or video files, offline, in lock step; the same input gives the same bytes."""
    prepare_workers()
    from mctrack_ros.cli.commands.database.store import check_database, store_results
    from mctrack_ros.cli.progress import progress_bar
    from mctrack_ros.cli.tables import show_figures
    from mctrack_ros.replay.camera_source import Debug
    from mctrack_ros.replay.track import Source, track_bag

    found, name = _source(sources, later, rate)
    source = Source(found, namespace, log_times) if isinstance(found, Path) else found
    if namespace and not isinstance(found, Path):
        raise ValueError('--namespace is for bags, which have topics: videos have none')
    if out is None:
        raise typer.BadParameter('name a folder for the results', param_hint='--out')
    if run and not store:
        raise typer.BadParameter('it names a run in a database: give --store', param_hint='--run')
    config = _site(site)
    if store:
        check_database(store, run, overwrite=overwrite)
    processes, started = processes or len(config.cameras), time.perf_counter()
    with progress_bar('tracking') as progress:
        summary = track_bag(
            source,
            out,
            config,
            processes=processes,
            overwrite=overwrite,
            explain=explain,
            debug=Debug(debug_images, debug_every) if debug_images else None,
            progress=progress,
        )
    wall_seconds = time.perf_counter() - started
    show_figures(_figures(summary, name, config, processes, wall_seconds), json_file)
    if summary.tracker:
        typer.echo(summary.tracker, err=True)
    _tell_place(out, config)
    if store:
        store_results(out, store, config.name, run, overwrite=overwrite)
    _tell_trouble(summary, out)


def _site(name: str) -> SiteConfig:
    """Return the site of that name, or the usual one; say so, and what is doubtful in it."""
    from mctrack_ros.cli.sites import calibration_doubts, camera_site

    if not name:
        typer.echo(f'--site is not given: the shipped {_USUAL_SITE} is taken', err=True)
    site = camera_site(name or _USUAL_SITE)
    for line in calibration_doubts(site):
        typer.echo(line, err=True)
    return site


def _figures(
    summary: TrackSummary, source: str, site: SiteConfig, processes: int, wall_seconds: float
) -> Figures:
    """Return the figures of a run."""
    from mctrack_ros.evaluation.figures import Figures

    return Figures(
        name='track',
        command=f'mctrack track {source} --site {site.name} --processes {processes}',
        protocol={'site': site.name, 'cameras': len(site.cameras), 'processes': processes},
        figures={
            'ticks': summary.ticks,
            'images': summary.images,
            'confirmed_ids': len(summary.confirmed_ids),
            'bag_seconds': summary.bag_seconds,
            'wall_seconds': wall_seconds,
            'realtime_factor': summary.bag_seconds / wall_seconds,
            'peak_memory_mb': summary.peak_memory_mb,
            **summary.cameras,
        },
    )


def _tell_place(out: Path, site: SiteConfig) -> None:
    """Print where results are, and what their positions are relative to."""
    from mctrack_ros.site.stated_origin import origin_text

    typer.echo(f'wrote {out / "bag"}, {out / "tracks.txt"} and {out / "tracks.csv"}')
    if any(site.origin):
        origin = origin_text(site.origin)
        typer.echo(
            f'positions in the bag are relative to the origin {origin}, '
            "those in the text are in the coordinates of the site's files"
        )


def _tell_trouble(summary: TrackSummary, out: Path) -> None:
    """Warn of what was odd; ValueError: something could not be read."""
    for note in summary.notes:
        warn(note)
    if summary.faults:
        raise ValueError(f'{"; ".join(summary.faults)}; {out} holds what was read')


def background(
    sources: list[str] = typer.Argument(
        ...,
        metavar='BAG | CAMERA=VIDEO...',
        help='Bag with the images of every camera, or the video file of each.',
    ),
    site: str = typer.Option(..., help='Site YAML, or the name of a shipped site.'),
    out: Path = typer.Option(..., help='Folder for the images, CAMERA.png.'),
    namespace: str = typer.Option(
        '', callback=namespace_of, help='Namespace of the cameras in the bag.'
    ),
    later: list[str] = LATER,
    rate: float = RATE,
    overwrite: bool = typer.Option(False, '--overwrite', help='Replace earlier images.'),
) -> None:
    """
    Make an image without people of each camera, from a recording in which people move about.

    It is the median of images spread over the recording. Name it in the site as `background` of
    the camera: then live cameras see people from the first image on.
    """
    from mctrack_ros.cli.progress import progress_bar
    from mctrack_ros.cli.sites import camera_site
    from mctrack_ros.replay.lockstep import camera_tasks
    from mctrack_ros.replay.video_tasks import video_tasks

    source, _ = _source(sources, later, rate)
    config = camera_site(site)
    if isinstance(source, Path):
        tasks = camera_tasks(source, config, namespace)
    else:
        tasks = video_tasks(source, config)
    files = {task.camera: out / f'{task.camera}.png' for task in tasks}
    for file in files.values():
        if file.exists() and not overwrite:
            raise FileExistsError(f'{file} exists: give --overwrite to replace it')
    out.mkdir(parents=True, exist_ok=True)
    with progress_bar('cameras') as progress:
        for done, task in enumerate(tasks):
            progress(done, len(tasks))
            _write_background(task, files[task.camera])
            progress(done + 1, len(tasks))
    typer.echo('look at the images; then add to the site:')
    for camera, file in files.items():
        typer.echo(f'  {camera}: background: {file}')


def _write_background(task: CameraTask, file: Path) -> None:
    """Make the image without people of a camera."""
    import cv2

    from mctrack_ros.replay.camera_source import LEAST_IMAGES, plate_of

    plate = plate_of(task)
    if plate is None:
        raise ValueError(
            f'{task.bag} holds fewer than {LEAST_IMAGES} usable images of {task.camera} '
            f'({task.image_topic}): record longer, at best for minutes'
        )
    cv2.imwrite(str(file), plate)


def _source(
    sources: list[str], later: list[str], rate: float
) -> tuple[Path | dict[str, Video], str]:
    """
    Return the bag, or the videos by camera, and how the command names them.

    Raises
    ------
    ValueError
        If it is neither one bag nor videos; says how a video is named.

    """
    from mctrack_ros.recording import is_bag

    path = Path(sources[0])
    if len(sources) > 1 or ('=' in sources[0] and not path.exists()):
        videos = open_videos(sources, later, rate)
        return videos, ' '.join(f'{name}={each.path.name}' for name, each in videos.items())
    if later or rate:
        raise ValueError('--later and --rate are for videos: camera=file')
    if path.exists() and not is_bag(path):
        raise ValueError(
            f'{path} is no bag; videos are named with the cameras of a site: '
            f'mctrack track CAMERA={path} ... --site SITE.yaml --out FOLDER'
        )
    return path, path.name


def echo(
    topic: str = typer.Argument(..., help='Topic of one of the clouds, for example /tracks.'),
    bag: Path | None = typer.Option(None, help='Read a bag instead of the running graph.'),
    namespace: str = typer.Option(
        '', callback=namespace_of, help='Namespace of the topic, for example /hall.'
    ),
    count: int = typer.Option(0, min=0, help='Stop after so many messages; 0: go on.'),
    as_json: bool = typer.Option(False, '--json', help='One JSON object a message.'),
) -> None:
    """Print a topic of rows (tracks, detections, events ...) as a table."""
    from rich.console import Console

    from mctrack_ros.cli.tables import cloud_table, cloud_values

    console, topic = Console(width=_TABLE_WIDTH), resolved(topic)
    for index, message in enumerate(_messages(topic, bag, namespace)):
        if as_json:
            typer.echo(json.dumps(cloud_values(topic, message)))
        else:
            console.print(cloud_table(topic, message))
        if index + 1 == count:
            return


def _messages(topic: str, bag: Path | None, namespace: str) -> Iterator[Any]:
    """Yield the clouds of a topic, from a bag or from the running graph."""
    if bag is None:
        from mctrack_ros.ros.topics.subscribe import clouds

        yield from clouds(namespace + topic)
        return
    from mctrack_ros.recording import BagError, BagReader

    with BagReader(bag, namespace) as reader:
        kind = reader.topics.get(topic)
        if kind not in (None, 'sensor_msgs/msg/PointCloud2'):
            raise BagError(f'{bag}: {topic} holds {kind}, expected sensor_msgs/msg/PointCloud2')
        for _, message, _ in reader.messages([topic]):
            yield message
