"""`mctrack doctor`: what is wrong with a site and a bag before they are run."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from mctrack_ros.site.names import namespace_of

if TYPE_CHECKING:
    from mctrack_ros.replay.doctor import Finding
    from mctrack_ros.site.site import SiteConfig


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
    from mctrack_ros.replay.doctor import examine_bag, examine_site

    config = named_site(site)
    findings = list(examine_site(config))
    if bag is not None:
        findings += examine_bag(bag, config, namespace)
    if clocks:
        if bag is None:
            raise typer.BadParameter('name the bag, too', param_hint='--clocks')
        findings += _examine_clocks(bag, config, namespace)
    has_errors = _show(findings, config, bag)
    if json_file is not None:
        json_file.write_text(json.dumps([one._asdict() for one in findings], indent=1) + '\n')
    if has_errors:
        raise typer.Exit(1)


def _examine_clocks(bag: Path, site: SiteConfig, namespace: str) -> list[Finding]:
    """Return what is wrong with the clocks of cameras."""
    from mctrack_ros.replay.clock_doctor import camera_clocks, findings

    return list(findings(camera_clocks(bag, site, namespace), site.fusion.clocks.limit))


def _show(findings: list[Finding], site: SiteConfig, bag: Path | None) -> bool:
    """Print findings, the worst first, and how many there are; tell whether some are errors."""
    from mctrack_ros.replay.doctor import Severity

    order = list(Severity)
    for finding in sorted(findings, key=lambda one: order.index(one.severity)):
        typer.echo(f'{finding.severity:<8}{finding.about}: {finding.what}')
        typer.echo(f'{"":8}-> {finding.remedy}')
    counts = Counter(finding.severity for finding in findings)
    summary = ', '.join(f'{counts[each]} {each}{"s" * (counts[each] != 1)}' for each in order)
    what = 'cells' if site.cells else 'cameras'
    looked = f'{len(site.camera_names)} {what}' + (f' and {bag}' if bag else '')
    typer.echo(f'{looked}: {summary}')
    return counts[Severity.ERROR] > 0
