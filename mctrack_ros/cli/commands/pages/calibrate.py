"""`mctrack calibrate`: pair the scene's points with a camera's image, in the browser."""

from __future__ import annotations

from pathlib import Path

import typer

from mctrack_ros.cli.options import BROWSER, HOST, PORT, TOKEN


def calibrate(
    source: Path = typer.Argument(
        ..., help='An image, a video or a bag of the camera, or live: the running graph.'
    ),
    scene: Path = typer.Argument(..., help="Scene XML: the points' names and metres."),
    camera: str = typer.Option(..., help="The camera's name."),
    out: Path = typer.Option(
        ..., help='Grid XML to write; an existing one is continued and replaced.'
    ),
    topic: str = typer.Option(
        '', help='Topic of images in the bag or the graph; found by its name unless given.'
    ),
    host: str = HOST,
    port: int = PORT,
    token: str = TOKEN,
    browser: bool = BROWSER,
) -> None:
    """Calibrate a camera in the browser: click points on a plan and in its image."""
    from mctrack_ros.ground import read_grid, read_scene
    from mctrack_ros.site.names import check_camera_name
    from mctrack_ros.web import Pairing, check_address, read_image

    check_camera_name(camera)
    check_address(host, token)
    image = read_image(source, camera, topic)
    height, width = image.shape[:2]
    pairing = Pairing(camera, read_scene(scene), (width, height))
    if out.exists():
        pairing.resume(read_grid(out))

    from mctrack_ros.web.calibrate.page import add_pages, desk
    from mctrack_ros.web.serve.serve import serve

    page = add_pages(desk(pairing, image, out))
    serve(page, f'Calibrate {camera}', host, port, token, browser, typer.echo)
