"""
`mctrack`: every command; what a command needs is imported when it runs.

Other distributions add theirs by an entry point of the group ``mctrack_ros.commands``: a function
that takes the typer application.
"""

from __future__ import annotations

import sys
import warnings
from importlib.metadata import entry_points
from typing import TextIO

import typer

from mctrack_ros import __version__
from mctrack_ros.cli.commands import (
    bag,
    calibration,
    demo,
    doctor,
    explain,
    graph,
    import_detections,
    offline,
    videos,
)
from mctrack_ros.cli.commands import evaluate as compare
from mctrack_ros.cli.commands.database import exchange, query, report, store, stream, upkeep
from mctrack_ros.cli.commands.pages import calibrate, coverage, live_map

app = typer.Typer(
    name='mctrack',
    help='Track people and vehicles with several static cameras on the ground plane.',
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={'help_option_names': ['-h', '--help']},
)


def _show_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f'mctrack {__version__}')
        raise typer.Exit


@app.callback()
def _root(
    version: bool = typer.Option(
        False, '--version', callback=_show_version, is_eager=True, help='Show the version.'
    ),
) -> None:
    """Track people and vehicles with several static cameras on the ground plane."""


app.command('demo')(demo.demo)
app.command('simulate')(offline.simulate)
app.command('import-videos')(videos.import_videos)
app.command('import-detections')(import_detections.import_detections)
app.command('track')(offline.track)
app.command('replay')(bag.replay)
app.command('background')(offline.background)
app.command('explain')(explain.explain)
app.command('echo')(offline.echo)
app.command('run')(graph.run)
app.command('record')(graph.record)
app.command('play')(graph.play)
app.command('calibrate')(calibrate.calibrate)
app.command('evaluate')(compare.evaluate)
app.command('coverage')(coverage.coverage)
app.command('map')(live_map.live_map)
app.command('doctor')(doctor.doctor)
app.command('check-calibration')(calibration.check_calibration)
app.command('convert-calibration')(calibration.convert_calibration)
app.command('report')(report.report)
app.command('store')(store.store)
app.command('export-bag')(store.export_bag)
app.command('stream')(stream.stream)
app.command('export')(exchange.export)
app.command('import-tracks')(exchange.import_tracks)
app.command('store-check')(upkeep.store_check)
app.command('forget')(upkeep.forget)
app.add_typer(query.app, name='query', help='Ask a trajectory database.')
app.add_typer(bag.app, name='bag', help='Describe and repair recordings.')
for plugin in entry_points(group='mctrack_ros.commands'):
    try:
        plugin.load()(app)
    except ImportError as error:
        print(f'warning: no commands of {plugin.value}: {error}', file=sys.stderr)


def _show_warning(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: TextIO | None = None,
    line: str | None = None,
) -> None:
    """Show a warning of the package as one line, others as Python does."""
    text = warnings.formatwarning(message, category, filename, lineno, line)
    if category.__module__.startswith('mctrack_ros.'):
        text = f'warning: {message}\n'
    print(text, end='', file=file or sys.stderr)


def _expected_errors() -> tuple[type[BaseException], ...]:
    """Return the exceptions of what the user can mend: they are shown as one line."""
    from mctrack_ros.codec import CodecError
    from mctrack_ros.config import ConfigError
    from mctrack_ros.ground import CalibrationError
    from mctrack_ros.recording import BagError, MotTextError
    from mctrack_ros.replay.lockstep import ReplayError
    from mctrack_ros.store.errors import StoreError

    return (
        BagError,
        CalibrationError,
        CodecError,
        ConfigError,
        MotTextError,
        ReplayError,
        StoreError,
        OSError,
        ValueError,
    )


def main() -> None:
    """Run the command line; an expected error is one line and exit code 1, a warning one line."""
    warnings.showwarning = _show_warning
    try:
        app()
    except Exception as error:
        if not isinstance(error, _expected_errors()):
            raise
        print(f'mctrack: {error}', file=sys.stderr)
        sys.exit(1)


if __name__ == '__main__':
    main()
