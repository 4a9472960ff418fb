"""`mctrack bag`: mend recordings."""

from __future__ import annotations

from pathlib import Path

import typer

app = typer.Typer(no_args_is_help=True)


@app.callback()
def _root() -> None:
    """Mend recordings."""


@app.command('repair')
def repair(
    bag: Path = typer.Argument(..., help='The bag, or one of its files; it is not changed.'),
    out: Path = typer.Argument(..., help='The bag to write.'),
    overwrite: bool = typer.Option(False, '--overwrite', help='Replace an earlier bag.'),
) -> None:
    """Write a finished bag with all that can be read of a cut or damaged one."""
    from mctrack_ros.recording.bags.repair import repair_bag

    count, seconds = repair_bag(bag, out, overwrite=overwrite)
    typer.echo(f'wrote {out}: {count} messages, {seconds:.3f} s')
