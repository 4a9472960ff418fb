"""`mctrack background`: images without people, from a recording, for live use."""

from __future__ import annotations

from pathlib import Path

import typer

from mctrack_ros.cli.commands.offline import recorded_source
from mctrack_ros.cli.commands.videos import LATER, RATE
from mctrack_ros.site.names import namespace_of


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
    import cv2

    from mctrack_ros.cli.progress import progress_bar
    from mctrack_ros.cli.sites import named_site
    from mctrack_ros.replay.camera_source import LEAST_IMAGES, LEAST_S, plate_of
    from mctrack_ros.replay.lockstep import camera_tasks
    from mctrack_ros.replay.video_tasks import video_tasks

    source, _ = recorded_source(sources, later, rate)
    config = named_site(site)
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
            plate = plate_of(task)
            if plate is None:
                raise ValueError(
                    f'{task.bag} holds fewer than {LEAST_IMAGES} usable images of {task.camera} '
                    f'({task.image_topic}), or is shorter than {LEAST_S:g} s: record longer, at '
                    'best for minutes'
                )
            cv2.imwrite(str(files[task.camera]), plate)
            progress(done + 1, len(tasks))
    typer.echo('look at the images; then add to the site:')
    for camera, file in files.items():
        typer.echo(f'  {camera}: background: {file}')
