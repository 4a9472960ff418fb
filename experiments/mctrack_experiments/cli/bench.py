"""`mctrack bench`: how fast the parts are, beside a peer in the same run."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from mctrack_experiments.bench.parts import Part
from mctrack_experiments.cli.options import RUNS

if TYPE_CHECKING:
    from mctrack_ros.evaluation.figures import Figures


app = typer.Typer(no_args_is_help=True)
_JSON = typer.Option(None, '--json', help='Also write the figures here.')
_SEEDS = typer.Option(
    None,
    help='Scenes on which accuracy is measured, for example 1-3; unless given, fresh ones, and '
    'the run is kept.',
)
_DOMAIN = typer.Option(
    None, min=0, max=232, help='ROS domain; unless given, that of ROS_DOMAIN_ID.'
)
_BENCHMARK = typer.Option(
    None, help='The benchmark; unless given, MCTRACK_BENCH or ../shared/bench.'
)


@app.command()
def ground(json_file: Path | None = _JSON) -> None:
    """Time the ground mappings: points a second."""
    from mctrack_experiments.bench.ground import bench_ground

    _tell(bench_ground(), json_file)


@app.command()
def start(json_file: Path | None = _JSON) -> None:
    """Time a first start, which compiles the inner loops, and a later one."""
    from mctrack_experiments.bench.start import bench_start

    _tell(bench_start(), json_file)


@app.command()
def camera_shift(json_file: Path | None = _JSON) -> None:
    """Time the watch for cameras that have moved."""
    from mctrack_experiments.bench.perception.camera_shift import bench_camera_shift

    _tell(bench_camera_shift(), json_file)


@app.command()
def camera(json_file: Path | None = _JSON) -> None:
    """Time a camera's trackers: images a second."""
    from mctrack_experiments.bench.perception.camera import bench_camera

    _tell(bench_camera(), json_file)


@app.command()
def belief(json_file: Path | None = _JSON) -> None:
    """Time belief propagation: images a second, without and with their likelihood."""
    from mctrack_experiments.bench.perception.belief import bench_belief

    _tell(bench_belief(), json_file)


@app.command()
def occupancy(
    data: Path | None = typer.Option(
        None, help='Folder of the real data; unless given, MCTRACK_DATA or ../shared/data.'
    ),
    json_file: Path | None = _JSON,
) -> None:
    """Time joint occupancy: 40 x 40 m with eight cameras, and EPFL's terrace."""
    from mctrack_experiments.bench.perception.occupancy import bench_occupancy
    from mctrack_experiments.cli.reproduce import data_folder

    _tell(bench_occupancy(data_folder(data)), json_file)


@app.command()
def store(
    bag: Path = typer.Option(
        Path('bags/pitch5_detections'), help='Bag of the detections whose tracks are stored.'
    ),
    minutes: int = typer.Option(60, min=2, help='How long a run of 25 tracks is stored.'),
    long: bool = typer.Option(
        False,
        '--long',
        help='Store a day in SQLite instead, some minutes, and say what a month takes.',
    ),
    json_file: Path | None = _JSON,
) -> None:
    """Time the trajectory database: positions a second, bytes a position, queries."""
    from mctrack_experiments.bench.store import bench_store, bench_store_long

    _tell(bench_store_long(bag) if long else bench_store(bag, minutes), json_file)


@app.command('map')
def live_map(json_file: Path | None = _JSON) -> None:
    """Time the live map: the server's share of a core, frames drawn a second in a browser."""
    from mctrack_experiments.bench.nodes.live_map import bench_map

    _tell(bench_map(), json_file)


@app.command()
def streams(
    bag: Path = typer.Option(
        Path('bags/pitch5_detections'), help='Bag of the detections whose tracks are streamed.'
    ),
    pairs: int = typer.Option(
        24, min=0, help='How often fusion is measured with and without hostile readers.'
    ),
    json_file: Path | None = _JSON,
) -> None:
    """Measure streams: bytes a second, and what two hundred hostile readers cost fusion."""
    from mctrack_experiments.bench.streams.bench import bench_streams

    _tell(bench_streams(bag, pairs, lambda line: typer.echo(line, err=True)), json_file)


@app.command()
def kills(
    count: int = typer.Option(50, '--kills', min=1, help='How often each is killed.'),
    seed: int = typer.Option(1, min=0, help='Of the moments.'),
    domain: int | None = _DOMAIN,
    json_file: Path | None = _JSON,
) -> None:
    """Kill the store, its database and the fusion node while tracks come: what is lost."""
    from mctrack_experiments.bench.nodes.kills import bench_kills

    _tell(bench_kills(count, seed, domain), json_file)


@app.command()
def chaos(
    domain: int = typer.Option(77, min=0, max=232, help='ROS domain that nobody else uses.'),
    json_file: Path | None = _JSON,
) -> None:
    """Let everything go wrong in a live graph: what names it, which ids are kept, what is lost."""
    from mctrack_experiments.bench.chaos.bench import bench_chaos

    _tell(bench_chaos(domain, lambda line: typer.echo(line, err=True)), json_file)


@app.command()
def fuzz(
    bag: Path = typer.Option(
        Path('bags/pitch5_detections'), help='Bag of the detections that are tracked meanwhile.'
    ),
    decoded: int = typer.Option(100_000, min=1, help='Messages that are decoded.'),
    sent: int = typer.Option(2000, min=1, help='Messages that are sent into a graph.'),
    domain: int | None = _DOMAIN,
    json_file: Path | None = _JSON,
) -> None:
    """Decode malformed messages and send some into a running graph: what breaks."""
    from mctrack_experiments.bench.fuzz.bench import bench_fuzz
    from mctrack_ros.cli.progress import progress_bar

    _tell(bench_fuzz(bag, decoded, sent, domain, progress_bar), json_file)


@app.command()
def soak(
    minutes: float = typer.Option(60.0, min=1.0, help='How long the site runs.'),
    domain: int | None = _DOMAIN,
    json_file: Path | None = _JSON,
) -> None:
    """Run a small site live for an hour: whether memory or latency grows."""
    from mctrack_experiments.bench.nodes.soak import bench_soak
    from mctrack_ros.cli.progress import progress_bar

    with progress_bar('soaking, s') as progress:
        figures = bench_soak(minutes, domain, progress)
    _tell(figures, json_file)


@app.command()
def zones(
    seeds: str | None = _SEEDS,
    runs: Path = RUNS,
    folder: Path | None = _BENCHMARK,
    json_file: Path | None = _JSON,
) -> None:
    """Time zone events a tick, and count who crosses lines beside the truth."""
    from mctrack_experiments.bench.fusion import toolkit_folder
    from mctrack_experiments.bench.zones import bench_zones
    from mctrack_experiments.runs import measured
    from mctrack_ros.cli.progress import progress_bar

    place = toolkit_folder(folder)

    def measure(seeds: Sequence[int]) -> Figures:
        return bench_zones(place, seeds, progress_bar)

    figures, spread = measured('bench_zones', seeds, runs, measure)
    _tell(figures, json_file)
    typer.echo(f'\n{spread}')


@app.command()
def cells(
    live: bool = typer.Option(
        False, '--live', help='One site, its cells and itself as nodes: load of each process.'
    ),
    seeds: str | None = _SEEDS,
    runs: Path = RUNS,
    json_file: Path | None = _JSON,
) -> None:
    """Follow people from cell to cell on a site of a hundred cameras: ids kept, load, accuracy."""
    if live:
        from mctrack_experiments.bench.cells.live import bench_cells_live

        _tell(bench_cells_live(progress=lambda line: typer.echo(line, err=True)), json_file)
        return
    from mctrack_experiments.bench.cells.bench import bench_cells
    from mctrack_experiments.runs import measured
    from mctrack_ros.cli.progress import progress_bar

    def measure(seeds: Sequence[int]) -> Figures:
        return bench_cells(seeds, progress_bar)

    figures, spread = measured('bench_cells', seeds, runs, measure)
    _tell(figures, json_file)
    typer.echo(f'\n{spread}')


@app.command()
def replay(
    bag: Path = typer.Option(
        Path('bags/pitch5_detections'), help='Bag of the detections that are fused.'
    ),
    replays: int = typer.Option(100, min=1, help='How often, each time in another order.'),
    json_file: Path | None = _JSON,
) -> None:
    """Replay a bag, its messages in any order of arrival: one hash; changed bits; speed."""
    from mctrack_experiments.bench.replay import bench_replay

    _tell(bench_replay(bag, replays), json_file)


@app.command()
def recording(
    bag: Path = typer.Option(
        Path('bags/pitch5_detections'), help='Bag of the detections that are played.'
    ),
    seconds: float = typer.Option(20.0, min=5.0, help='How long is played.'),
    json_file: Path | None = _JSON,
) -> None:
    """Play five cameras with all outputs and record them: processor time, losses, spacing."""
    from mctrack_experiments.bench.recording import bench_recording

    _tell(bench_recording(bag, seconds), json_file)


@app.command('live-replay')
def live_replay(
    bag: Path = typer.Option(
        Path('bags/pitch5_detections'), help='Bag of the detections that are played.'
    ),
    runs: int = typer.Option(2, min=1, help='How often at each speed.'),
    json_file: Path | None = _JSON,
) -> None:
    """Play a bag into a live fusion node at 0.5 to 1000 times its speed; verify each run."""
    from mctrack_experiments.bench.nodes.live_replay import bench_live_replay

    _tell(bench_live_replay(bag, runs), json_file)


@app.command()
def fusion(
    part: list[Part] = typer.Option([], help='Measure this alone; may be repeated.'),
    seeds: str | None = _SEEDS,
    runs: Path = RUNS,
    quick: bool = typer.Option(False, '--quick', help='Time fewer ticks, no slow trackers.'),
    alone: bool = typer.Option(False, '--alone', help='Run no other trackers.'),
    folder: Path | None = _BENCHMARK,
    json_file: Path | None = _JSON,
) -> None:
    """Measure fusion on synthetic scenes: time, accuracy beside other trackers, bad input."""
    from mctrack_experiments.bench import fusion as fusion_bench
    from mctrack_experiments.runs import measured
    from mctrack_ros.cli.progress import progress_bar

    peers = () if alone else fusion_bench.installed_peers()
    missing = [name for name in fusion_bench.PEERS if name not in peers and not alone]
    if missing:
        names = ', '.join(missing)
        typer.echo(f'measuring without {names}; to have them: {fusion_bench.INSTALL}', err=True)
    place, parts = fusion_bench.toolkit_folder(folder), tuple(part or Part)

    def measure(seeds: Sequence[int]) -> Figures:
        return fusion_bench.bench_fusion(place, peers, parts, seeds, quick, progress_bar)

    if Part.ACCURACY in parts:
        figures, spread = measured('bench_fusion', seeds, runs, measure)
    else:
        figures, spread = measure(()), ''
    _tell(figures, json_file)
    if spread:
        typer.echo(f'\n{spread}')


def _tell(figures: Figures, json_file: Path | None) -> None:
    """Print figures and, if asked, write them."""
    typer.echo(figures.table())
    if json_file is not None:
        figures.write(json_file)
