"""`mctrack export`, `import-tracks`: tracks in files of other tools."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from mctrack_ros.cli import options

if TYPE_CHECKING:
    from mctrack_ros.interfaces import Tracks
    from mctrack_ros.recording.tracks.pitch import Pitch
    from mctrack_ros.site.site import SiteConfig

_FORMAT = typer.Option(
    '',
    '--format',
    help='mot, csv, parquet, geojson, mf-json, pedpy, epts or tracab; by default as the name '
    'ends, where that can be one alone.',
)
_SITE = typer.Option('', help='Site YAML, or the name of a shipped site: its area is the pitch.')
_PITCH = typer.Option(
    '',
    help='The pitch of epts and tracab, m: x0,y0,x1,y1 or its four corners x,y (--pitch=-1,... '
    'where it begins with a minus).',
)


def export(
    source: str = typer.Argument(
        ..., help='Database (a file, or a URL), or bag, or what `mctrack track` wrote.'
    ),
    out: Path = typer.Argument(
        ...,
        callback=options.output_file,
        help='File to write; epts and tracab write metadata, too.',
    ),
    form: str = _FORMAT,
    run: str = options.RUN,
    began: Any = options.FROM,
    ended: Any = options.TO,
    as_reported: bool = options.AS_REPORTED,
    rate: float | None = typer.Option(
        None,
        min=0.001,
        max=1000.0,
        help='Frames a second of mot, pedpy, epts and tracab; by default as many as the run has '
        'ticks.',
    ),
    site: str = _SITE,
    pitch: str = _PITCH,
    away: str = typer.Option(
        '',
        help='Ids of the away team in epts and tracab, with commas between; by default whoever '
        'wears the second most frequent clothing. All others are at home.',
    ),
) -> None:
    """Write tracks into a file of another tool; identities as they are known now."""
    from mctrack_ros.cli.sites import optional_site
    from mctrack_ros.recording.tracks.formats import format_of
    from mctrack_ros.store import View
    from mctrack_ros.store.exchange import Export, export_tracks, opened_run

    chosen = format_of(out, form)
    on = _pitch(pitch, optional_site(site)) if chosen.is_on_pitch else None
    teams = _ids(away)
    with opened_run(source, run, View(corrected=not as_reported)) as opened:
        wanted = Export(options.times(opened, began, ended), rate, on, teams)
        made = export_tracks(opened, out, chosen, wanted)
    files = ' and '.join(str(file) for file in made.files)
    typer.echo(f'wrote {files}: {made.positions} positions of {made.tracks} tracks')
    if made.rate_hz:
        typer.echo(
            f'{made.rate_hz:g} frames a second; times were moved by at most '
            f'{made.moved_s * 1000:.1f} ms'
        )
    if made.left_out:
        typer.echo(
            f'{made.left_out} instants are left out: another is in the same frame (a higher '
            '--rate keeps them)',
            err=True,
        )


def import_tracks(
    file: Path = typer.Argument(..., help='The file; metadata stand beside it.'),
    bag: Path | None = typer.Option(None, help='Bag to write.'),
    database: str = typer.Option('', help='Database to write to: a file, or a URL.'),
    form: str = _FORMAT,
    run: str = typer.Option('', help='What the run is called; by default as the file.'),
    rate: float = typer.Option(
        25.0, min=0.001, max=1000.0, help='Frames a second of files that do not say it.'
    ),
    site: str = _SITE,
    pitch: str = _PITCH,
    overwrite: bool = typer.Option(False, '--overwrite', help='Replace an earlier bag.'),
) -> None:
    """Read tracks of another tool into a bag, a database, or both."""
    from mctrack_ros.cli.sites import optional_site
    from mctrack_ros.site.description import site_description
    from mctrack_ros.store import Database, NewRun
    from mctrack_ros.store.exchange import store_tracks, write_tracks_bag

    if bag is None and not database:
        raise typer.BadParameter('name where it goes: --bag BAG, --database DATABASE, or both')
    config = optional_site(site)
    read, origin = _read(file, form, rate, config, pitch)
    name, frame_id = run or file.stem, config.ground_frame if config else 'map'
    said = site_description({'origin': list(origin), 'fusion': {}}, [], name, {})
    if bag is not None:
        write_tracks_bag(read, bag, frame_id, said, overwrite=overwrite)
    if database:
        new = NewRun(name, config.name if config else 'site', (), frame_id)
        with Database(database, create=True) as opened:
            store_tracks(read, opened, new, said)
    ids = {who for rows in read for who in rows.track_id.tolist()}
    places = ' and '.join(filter(None, [str(bag or ''), database]))
    typer.echo(f'wrote {places}: {sum(map(len, read))} positions of {len(ids)} tracks')


def _read(
    file: Path, form: str, rate_hz: float, site: SiteConfig | None, pitch: str
) -> tuple[list[Tracks], tuple[float, float]]:
    """
    Return the tracks of a file and the origin of their positions: the site's, or one near them.

    Raises
    ------
    ValueError
        If it holds none, or they are far from the site.

    """
    import numpy as np

    from mctrack_ros.recording.tracks.collected import Layout
    from mctrack_ros.recording.tracks.formats import format_of
    from mctrack_ros.recording.video.videos import START_NS
    from mctrack_ros.site.origin import FARTHEST_M, chosen_origin

    chosen = format_of(file, form)
    on = _pitch(pitch, site) if chosen.is_on_pitch else None
    origin = site.origin if site else (0.0, 0.0)
    layout = Layout(round(1e9 / rate_hz), START_NS, origin, pitch=on)
    read = chosen.read(file, layout)
    if not read:
        raise ValueError(f'{file} holds no tracks')
    away = chosen_origin(np.concatenate([rows.position[:, :2] for rows in read]))
    if not any(away):
        return read, origin
    if site:
        raise ValueError(
            f'{file}: its positions are farther than {FARTHEST_M / 1000:g} km from the origin of '
            f'{site.name}'
        )
    return chosen.read(file, replace(layout, origin=away)), away


def _pitch(text: str, site: SiteConfig | None) -> Pitch | None:
    """Return the pitch that is named, or the area of a site."""
    import shapely

    from mctrack_ros.ground.coverage.coverage import area_from
    from mctrack_ros.recording.tracks.pitch import Pitch

    text = text or (site.area if site else '')
    if not text:
        return None
    return Pitch.from_corners(shapely.get_coordinates(area_from(text))[:-1])


def _ids(text: str) -> frozenset[int] | None:
    try:
        return frozenset(int(each) for each in text.split(',')) if text else None
    except ValueError as error:
        raise typer.BadParameter(f'{text!r}: expected ids with commas between') from error
