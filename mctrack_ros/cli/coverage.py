"""`mctrack coverage`: what the cameras of a site see, and how well."""

from __future__ import annotations

from pathlib import Path

import typer


def coverage(
    site: str = typer.Argument(..., help='Site YAML, or the name of a shipped site.'),
    area: str = typer.Option(
        '',
        help='What is to be covered [m]: x0,y0,x1,y1 or the corners x,y of a polygon. By default '
        "the site's `area`, or else the rectangle around all that is seen.",
    ),
    cell: float = typer.Option(
        0.5, min=0.01, max=100.0, help='Edge of a cell of the error map [m].'
    ),
    reach: float = typer.Option(
        200.0, min=1.0, max=10000.0, help='How far from its foot a camera is of use [m].'
    ),
    json_file: Path | None = typer.Option(None, '--json', help='Also write the figures here.'),
    picture: Path | None = typer.Option(
        None, '--picture', help='Also draw it here, as .png, .svg or .pdf.'
    ),
) -> None:
    """Show what a site's cameras see: overlaps, blind areas, hand-overs, predicted errors."""
    from mctrack_ros.cli.sites import named_site
    from mctrack_ros.experiments.coverage_figures import coverage_figures
    from mctrack_ros.ground.coverage import CoverageConfig
    from mctrack_ros.site_coverage import site_coverage

    loaded = named_site(site)
    seen = site_coverage(loaded, CoverageConfig(cell=cell, reach=reach), area)
    options = f' --area={area}' if area else ''
    command = f'mctrack coverage {site}{options} --cell {cell:g} --reach {reach:g}'
    figures = coverage_figures(seen, loaded.name, command)
    typer.echo(figures.table())
    if json_file is not None:
        figures.write(json_file)
    if picture is not None:
        from mctrack_ros.experiments.coverage_picture import draw_coverage

        draw_coverage(seen, f'Coverage of {loaded.name}', picture)
