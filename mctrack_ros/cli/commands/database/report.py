"""`mctrack report`: a page and a PDF of a run."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Any

import typer

from mctrack_ros.cli import options

_ENDINGS = ('.html', '.pdf')


def report(
    source: str = typer.Argument(
        ..., help='What `mctrack track` wrote, or a bag, or a database (a file, or a URL).'
    ),
    out: list[Path] = typer.Argument(
        None, help='Files to write, as .html or .pdf; unless given, report.html.'
    ),
    site: str = typer.Option(
        '',
        help='Site YAML, or the name of a shipped site, for its area and what its cameras see.',
    ),
    title: str = typer.Option('', help='Title; by default the name of the source.'),
    run: str = options.RUN,
    began: Any = options.FROM,
    ended: Any = options.TO,
    as_reported: bool = options.AS_REPORTED,
) -> None:
    """Tell of a run in a page and a PDF: who was where, how far and how fast, how good it is."""
    from mctrack_ros.cli.sites import optional_site
    from mctrack_ros.report.run.data import run_data
    from mctrack_ros.report.run.page import write_run_report
    from mctrack_ros.store import View
    from mctrack_ros.store.exchange import bag_of, opened_run

    files = out or [Path('report.html')]
    for file in files:
        if file.suffix.lower() not in _ENDINGS:
            raise typer.BadParameter(f'{file} ends in neither .html nor .pdf')
        options.output_file(file)
    bag = bag_of(source)
    with opened_run(source, run, View(corrected=not as_reported)) as opened:
        data = run_data(
            opened,
            options.times(opened, began, ended),
            title=title or (Path(source).resolve().name if bag else opened.name),
            bag=bag,
            site=optional_site(site),
        )
    stated = f' --site {shlex.quote(Path(site).name)}' if site else ''
    command = f'mctrack report {shlex.quote(Path(source).name)}{stated}'
    write_run_report(data, files, command)
    for file in files:
        typer.echo(f'wrote {file}')
