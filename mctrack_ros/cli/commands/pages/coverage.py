"""`mctrack coverage`: what the cameras of a site see, and how well."""

from __future__ import annotations

from pathlib import Path

import typer

from mctrack_ros.cli.options import BROWSER, HOST, PORT, TOKEN, image_file


def coverage(
    site: str = typer.Argument(..., help='Site YAML, or the name of a shipped site.'),
    area: str = typer.Option(
        '',
        help='What is to be covered, m: x0,y0,x1,y1 or the corners x,y of a polygon. By default '
        "the site's `area`, or else the rectangle around all that is seen.",
    ),
    cell: float = typer.Option(
        0.5, min=0.01, max=100.0, help='Edge of a cell of the error map, m.'
    ),
    reach: float = typer.Option(
        200.0, min=1.0, max=10000.0, help='Range of a camera, from its foot, m.'
    ),
    json_file: Path | None = typer.Option(None, '--json', help='Also write the figures here.'),
    image: Path | None = typer.Option(
        None,
        '--image',
        callback=image_file,
        help='Also draw it here, as .png, .svg or .pdf.',
    ),
    web: bool = typer.Option(
        False, '--web', help='Show it in the browser, where fields of view are drawn and saved.'
    ),
    sources: list[str] = typer.Option(
        [],
        '--source',
        help='With --web, to draw on: camera=source, a source as `calibrate` takes it; '
        'a bag or live alone: for all cameras. May be repeated.',
    ),
    host: str = HOST,
    port: int = PORT,
    token: str = TOKEN,
    browser: bool = BROWSER,
) -> None:
    """Show what a site's cameras see: overlaps, blind areas, hand-overs, predicted errors."""
    from mctrack_ros.cli.sites import camera_site
    from mctrack_ros.cli.tables import show_figures
    from mctrack_ros.ground.coverage.coverage import CoverageConfig
    from mctrack_ros.report.coverage_figures import coverage_figures
    from mctrack_ros.site.coverage import site_coverage

    if sources and not web:
        raise ValueError('--source names images to draw on, which needs --web')
    loaded, config = camera_site(site), CoverageConfig(cell=cell, reach=reach)
    seen = site_coverage(loaded, config, area)
    options = f' --area={area}' if area else ''
    command = f'mctrack coverage {site}{options} --cell {cell:g} --reach {reach:g}'
    show_figures(coverage_figures(seen, loaded.name, command), json_file)
    title = f'Coverage of {loaded.name}'
    if image is not None:
        from mctrack_ros.report.coverage_image import draw_coverage

        draw_coverage(seen, title, image)
    if web:
        from mctrack_ros.web.coverage.page import coverage_page
        from mctrack_ros.web.coverage.site_fields import save_fields, site_fields
        from mctrack_ros.web.coverage.site_images import site_images
        from mctrack_ros.web.serve.serve import serve

        images = site_images(loaded, sources)
        fields = site_fields(loaded, config, area)
        page = coverage_page(fields, title, lambda: save_fields(loaded, fields), images)
        serve(page, title, host, port, token, browser, typer.echo)
