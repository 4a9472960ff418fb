"""`mctrack demo`: render a match, track it live, show how well it went."""

from __future__ import annotations

import dataclasses
import os
import shutil
import sys
import time
import webbrowser
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

if TYPE_CHECKING:
    from mctrack_ros.report.demo import DemoOptions
    from mctrack_ros.ros.graph.graph import NodeSpec
    from mctrack_ros.site.site import SiteConfig

_OUT = typer.Option(Path('out/demo'), help='Folder for the results, which are replaced.')
_JSON = typer.Option(None, '--json', help='Also write the figures here.')
_DOMAIN = typer.Option(
    None, min=0, max=232, help='ROS domain; unless given, that of ROS_DOMAIN_ID.'
)
_OUTPUTS = '/(tracks|events|feedback|ticks|site)'


def demo(
    seconds: float = typer.Option(120.0, min=1.0, help='Length of the match, s.'),
    cameras: int = typer.Option(5, min=1, max=5, help='How many of the five cameras.'),
    offline: bool = typer.Option(False, '--offline', help='Track without ROS, in lock step.'),
    seed: int = typer.Option(1, min=0, help='Seed of the simulation.'),
    out: Path = _OUT,
    domain: int | None = _DOMAIN,
    json_file: Path | None = _JSON,
    show_map: bool = typer.Option(
        True, '--map/--no-map', help='Offer a live map to watch it on, and open it on a desktop.'
    ),
) -> None:
    """Render a five-camera football pitch, track it live, and report into out/demo."""
    from mctrack_ros.cli.progress import progress_bar
    from mctrack_ros.cli.tables import show_figures
    from mctrack_ros.report.demo import DemoOptions, evaluate_demo
    from mctrack_ros.simulation import Scenario
    from mctrack_ros.simulation.recording import simulate

    options = DemoOptions(seconds, cameras, offline, seed, out)
    site = _site(cameras)
    with progress_bar('rendering') as progress:
        scenario = Scenario(seed=seed, duration_s=seconds, cameras=cameras)
        simulate(scenario, options.source, overwrite=True, progress=progress)
    _remove_database(options.database)
    wall_seconds = None
    if offline:
        wall_seconds = _track_offline(options, site)
    else:
        _track_live(options, site, domain, show_map)
    mappings = [settings.mapping() for settings in site.cameras.values()]
    with progress_bar('evaluating') as progress:
        figures = evaluate_demo(options, mappings, wall_seconds, _settings(site), progress)
    show_figures(figures, json_file)
    typer.echo(f'\nopen {(out / "report.html").resolve().as_uri()}')


def _remove_database(path: Path) -> None:
    """Remove the database of an earlier demo, and what waited for it."""
    for ending in ('', '-wal', '-shm'):
        path.with_name(path.name + ending).unlink(missing_ok=True)
    shutil.rmtree(path.with_name(f'{path.name}.spool'), ignore_errors=True)


def _site(cameras: int) -> SiteConfig:
    """Return the shipped site with its first cameras."""
    from mctrack_ros.cli.sites import named_site

    site = named_site('pitch5')
    kept = dict(list(site.cameras.items())[:cameras])
    return dataclasses.replace(site, cameras=kept)


def _settings(site: SiteConfig) -> dict[str, Any]:
    """Return what the page shows of the site; the paths of its files are left out."""
    from mctrack_ros.config import values_of

    pipelines = {name: values_of(camera.pipeline) for name, camera in site.cameras.items()}
    return {
        'site': site.name,
        'feedback_delay': site.feedback_delay,
        'fusion': values_of(site.fusion),
        'cameras': pipelines,
    }


def _track_offline(options: DemoOptions, site: SiteConfig) -> float:
    """Track in lock step and store the results; return how long tracking took, s."""
    from mctrack_ros.cli.commands.database.store import store_results
    from mctrack_ros.cli.progress import progress_bar
    from mctrack_ros.replay.track import track_bag

    began_s = time.monotonic()
    with progress_bar('tracking') as progress:
        track_bag(options.source, options.out, site, overwrite=True, progress=progress)
    wall_seconds = time.monotonic() - began_s
    store_results(options.out, options.database, site.name, overwrite=False)
    return wall_seconds


def _track_live(
    options: DemoOptions, site: SiteConfig, domain: int | None, show_map: bool
) -> None:
    """Play the bag into the real graph and record what it publishes."""
    from mctrack_ros.cli.live import run_to_end
    from mctrack_ros.ros.graph.site_graph import site_nodes, store_node

    fusion, *cameras = site_nodes(site)
    ids = {'state_file': ''}  # the players of every demo are called 1 to 25
    fusion = dataclasses.replace(fusion, parameters={**fusion.parameters, **ids})
    store = store_node(options.database, site, finish=True)
    nodes = [fusion, *cameras, store, *_recorder_and_player(options, site)]
    typer.echo(f'tracking {options.seconds:g} s live with {len(nodes)} processes', err=True)
    with _watched(options, domain) if show_map else nullcontext():
        run_to_end(nodes, options.out / 'graph.log', domain)


@contextmanager
def _watched(options: DemoOptions, domain: int | None) -> Iterator[None]:
    """Offer a map of what goes on meanwhile, and open it on a desktop."""
    from mctrack_ros.cli.lazy_map import LazyMap

    log = options.out / 'map.log'
    with LazyMap(['pitch5', '--database', str(options.database.absolute())], log, domain) as shown:
        typer.echo(f'watch it at {shown.address}', err=True)
        if _has_desktop():
            webbrowser.open(shown.address)
        yield
    if shown.has_failed:
        typer.echo(f'warning: the map could not be shown: see {log}', err=True)
    typer.echo(f'watch it again: mctrack map pitch5 --bag {options.recorded}', err=True)


def _has_desktop() -> bool:
    """Tell whether somebody sits before this terminal who sees a browser open."""
    display = sys.platform == 'darwin' or {'DISPLAY', 'WAYLAND_DISPLAY'} & os.environ.keys()
    return sys.stderr.isatty() and bool(display) and 'CI' not in os.environ


def _recorder_and_player(options: DemoOptions, site: SiteConfig) -> list[NodeSpec]:
    from mctrack_ros.ros.graph.graph import player_node, recorder_node
    from mctrack_ros.ros.graph.site_graph import awaited_topics

    camera = f'/({"|".join(site.camera_names)})'
    played = [f'{camera}/image_raw/compressed', '/truth/tracks']
    recorded = [f'{camera}/(detections|events)', '/truth/tracks', _OUTPUTS]
    return [
        recorder_node(options.recorded.absolute(), recorded, overwrite=True),
        player_node(
            options.source.absolute(),
            topics=played,
            wait_for=[*awaited_topics(site, recorded=True, stored=True), '/truth/tracks'],
            restamp=True,
        ),
    ]
