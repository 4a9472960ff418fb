"""`mctrack doctor`: what is wrong with a site and a bag before they are run."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path

import typer

from mctrack_ros.site.names import namespace_of


def doctor(
    site: str = typer.Argument(..., help='Site YAML, or the name of a shipped site.'),
    bag: Path | None = typer.Argument(None, help='A bag to be tracked with it.'),
    namespace: str = typer.Option(
        '', callback=namespace_of, help='Namespace of the cameras in the bag.'
    ),
    clocks: bool = typer.Option(
        False,
        '--clocks',
        help="Measure the cameras' clocks by who moves in several views of the bag.",
    ),
    json_file: Path | None = typer.Option(None, '--json', help='Also write the findings here.'),
) -> None:
    """Report what is wrong with a site and a bag, and what to do; exit code 1: an error."""
    from mctrack_ros.cli.sites import named_site
    from mctrack_ros.replay.doctor import Severity, examine_bag, examine_site

    config = named_site(site)
    findings = list(examine_site(config))
    if bag is not None:
        findings += examine_bag(bag, config, namespace)
    if clocks:
        from mctrack_ros.replay.clock_doctor import camera_clocks
        from mctrack_ros.replay.clock_doctor import findings as clock_findings

        if bag is None:
            raise typer.BadParameter('name the bag, too', param_hint='--clocks')
        limit_s = config.fusion.clocks.limit
        findings += clock_findings(camera_clocks(bag, config, namespace), limit_s)
    order = list(Severity)
    for finding in sorted(findings, key=lambda one: order.index(one.severity)):
        typer.echo(f'{finding.severity:<8}{finding.about}: {finding.what}')
        typer.echo(f'{"":8}-> {finding.remedy}')
    counts = Counter(finding.severity for finding in findings)
    summary = ', '.join(f'{counts[each]} {each}{"s" * (counts[each] != 1)}' for each in order)
    what = 'cells' if config.cells else 'cameras'
    looked = f'{len(config.camera_names)} {what}' + (f' and {bag}' if bag else '')
    typer.echo(f'{looked}: {summary}')
    if json_file is not None:
        json_file.write_text(json.dumps([one._asdict() for one in findings], indent=1) + '\n')
    if counts[Severity.ERROR]:
        raise typer.Exit(1)
