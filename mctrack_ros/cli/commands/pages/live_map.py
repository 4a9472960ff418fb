"""`mctrack map`: see where everybody is, in the browser."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from mctrack_ros.cli.options import BROWSER, HOST, PORT, TOKEN
from mctrack_ros.site.names import namespace_of

if TYPE_CHECKING:
    from mctrack_ros.ros.topics.live_graph import LiveGraph
    from mctrack_ros.site.site import SiteConfig
    from mctrack_ros.web.live.live_map import LiveMap


def live_map(
    site: str = typer.Argument(
        '', help='Site YAML, or the name of a shipped site; unless given, tracks alone are shown.'
    ),
    database: str = typer.Option(
        '', help='Trajectory database with the past: a file, or a URL; it may still be written.'
    ),
    run: str = typer.Option('', help='Name of its run; by default the newest.'),
    bag: Path | None = typer.Option(
        None,
        help='Show the tracks and events of a bag, or of what `mctrack track` wrote, instead of '
        'the running graph.',
    ),
    namespace: str = typer.Option(
        '', callback=namespace_of, help='Namespace of the graph, for example hall.'
    ),
    domain: int | None = typer.Option(
        None, min=0, max=232, help='ROS domain; unless given, that of ROS_DOMAIN_ID.'
    ),
    host: str = HOST,
    port: int = PORT,
    token: str = TOKEN,
    browser: bool = BROWSER,
) -> None:
    """Show tracks, events and cameras on a map in the browser, now and in the past."""
    from mctrack_ros.cli.progress import progress_bar
    from mctrack_ros.cli.sites import optional_site
    from mctrack_ros.store.exchange import bag_of, stored_bag
    from mctrack_ros.web import check_address
    from mctrack_ros.web.live.backdrop import backdrop, no_backdrop
    from mctrack_ros.web.live.live_map import LiveMap
    from mctrack_ros.web.live.page import add_pages
    from mctrack_ros.web.live.past import Past
    from mctrack_ros.web.live.site_zones import SiteZones
    from mctrack_ros.web.serve.serve import serve

    if bag is not None and database:
        raise ValueError('--bag and --database both name the past: give one of them')
    check_address(host, token)
    loaded = optional_site(site)
    listen = None if bag else _listener(loaded, namespace, domain)
    with ExitStack() as stack:
        place = database
        if bag is not None:
            with progress_bar('reading') as progress:
                place = str(stack.enter_context(stored_bag(bag_of(bag) or bag, progress)))
        past = Past(place, run) if place else None
        ground = backdrop(loaded) if loaded else no_backdrop(bag.name if bag else 'tracks')
        zones = SiteZones(loaded) if loaded else None
        title = f'Map of {ground["name"]}'
        plan = loaded.floor_plan if loaded else None
        page = add_pages(LiveMap(ground, listen, past, zones), title, plan)
        serve(page, title, host, port, token, browser, typer.echo)


def _listener(
    site: SiteConfig | None, namespace: str, domain: int | None
) -> Callable[[LiveMap], LiveGraph]:
    """Return what lets a map listen to the running graph, and to the images of its cameras."""
    from mctrack_ros.site.names import named_image_topic, resolved

    cameras = site.cameras if site and not site.private else {}
    topics = {
        name: resolved(named_image_topic(name, settings.image_topic), namespace)
        for name, settings in cameras.items()
    }

    def listen(listener: LiveMap) -> LiveGraph:
        from mctrack_ros.ros.topics.live_graph import LiveGraph

        return LiveGraph(listener, namespace, topics, domain)

    return listen
