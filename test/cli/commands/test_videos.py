"""Videos tracked by `mctrack track`, directly and by way of a bag."""

from collections import Counter

import numpy as np
import pytest
import yaml
from typer.testing import CliRunner

from command_line import mctrack
from drawn_hall import PERIOD_NS, SIZE, VIEWS, image, projection, walkers
from films import cut, write_film
from mctrack_ros.cli.main import app
from mctrack_ros.ground import ProjectiveMapping

pytestmark = pytest.mark.xdist_group('replay')


@pytest.fixture(scope='module')
def hall(tmp_path_factory):
    """Return the folder of a site and its two films, one slower in the middle."""
    folder = tmp_path_factory.mktemp('hall')
    rng, cameras = np.random.default_rng(5), {}
    for name, position in VIEWS.items():
        matrix = projection(position)
        (folder / f'{name}.yaml').write_text(f'image_from_world: {matrix.tolist()}')
        cameras[name] = {
            'calibration': f'{name}.yaml',
            'image_width': SIZE[0],
            'image_height': SIZE[1],
        }
        mapping = ProjectiveMapping(matrix, SIZE)
        indices = [i for i in range(125) if name == 'south' or not (50 < i < 90 and i % 2)]
        times = [index * PERIOD_NS * 1e-9 for index in indices]
        images = [image(mapping, walkers(t)[: 0 if t < 1.5 else None], rng) for t in times]
        write_film(folder / f'{name}.mp4', times, images, movflags='faststart')
    (folder / 'site.yaml').write_text(yaml.safe_dump({'name': 'hall', 'cameras': cameras}))
    return folder


def run(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def track(hall, out, *arguments):
    return run('track', *arguments, '--site', hall / 'site.yaml', '--out', out)


def films(hall, **others):
    return [f'{name}={others.get(name, hall / f"{name}.mp4")}' for name in VIEWS]


def error_of(*arguments):
    """Return what the command prints as its error."""
    code, _, errors = mctrack(*arguments)
    assert code == 1
    return errors.splitlines()[-1]


def test_videos_give_the_tracks_of_the_bag_that_is_made_of_them(hall, tmp_path):
    assert run('import-videos', tmp_path / 'bag', *films(hall)).exit_code == 0
    assert track(hall, tmp_path / 'a', tmp_path / 'bag').exit_code == 0
    assert track(hall, tmp_path / 'b', *films(hall)).exit_code == 0
    first, second = (
        {path.relative_to(folder): path.read_bytes() for path in folder.rglob('*.*')}
        for folder in (tmp_path / 'a', tmp_path / 'b')
    )
    assert first == second
    lines = (tmp_path / 'b' / 'tracks.txt').read_text().splitlines()
    lived = Counter(line.split(',')[1] for line in lines)
    assert sorted(lived.values())[-3] > 75  # of the 81 images that show people
    assert len(lived) <= 4  # two films of sixteen have a ghost, by their noise


@pytest.mark.parametrize('options', [[], ['--site', 'site.yaml', '--out', 'out']])
def test_a_video_alone_is_answered_by_how_it_is_named(hall, monkeypatch, options):
    monkeypatch.chdir(hall)
    line = error_of('track', 'north.mp4', *options)
    assert 'mctrack track CAMERA=north.mp4 ... --site SITE.yaml --out FOLDER' in line


def test_results_need_a_folder(hall):
    done = run('track', *films(hall), '--site', hall / 'site.yaml')
    assert done.exit_code == 2
    assert '--out' in done.output


@pytest.mark.parametrize(
    ('arguments', 'reason'),
    [
        (['north=north.mp4'], 'no video of camera south'),
        (['north=north.mp4', 'south=south.mp4', 'nord=north.mp4'], 'has no camera nord'),
        (['north=north.mp4', 'south=none.mp4'], 'none.mp4 does not exist'),
        (
            ['north=north.mp4', 'south=small.mp4'],
            'of 64 x 48 px, but south of the site hall takes',
        ),
        (['north=north.mp4', 'south.mp4'], "'south.mp4': expected a camera and its value"),
        (['north.mp4', '--rate', '25'], '--later and --rate are for videos'),
    ],
)
def test_wrong_videos_end_in_one_line(hall, tmp_path, monkeypatch, arguments, reason):
    monkeypatch.chdir(hall)
    write_film(hall / 'small.mp4', [0.0, 0.04, 0.08])
    site = ('--site', 'site.yaml', '--out', tmp_path / 'out')
    assert reason in error_of('track', *arguments, *site)
    assert not (tmp_path / 'out').exists()


def test_a_video_that_breaks_off_is_tracked_to_there(hall, tmp_path):
    broken = tmp_path / 'broken.mp4'
    broken.write_bytes((hall / 'south.mp4').read_bytes())
    cut(broken, 0.7)
    site = ('--site', hall / 'site.yaml', '--out', tmp_path / 'out')
    line = error_of('track', *films(hall, south=broken), *site)
    assert 'broken.mp4 breaks off after' in line
    assert (tmp_path / 'out' / 'tracks.txt').read_text()


def test_a_later_start_and_a_rate_serve_both_commands(hall, tmp_path):
    options = ('--later', 'south=0.4', '--rate', '20')
    assert run('import-videos', tmp_path / 'bag', *films(hall), *options).exit_code == 0
    assert track(hall, tmp_path / 'a', tmp_path / 'bag').exit_code == 0
    assert track(hall, tmp_path / 'b', *films(hall), *options).exit_code == 0
    first, second = ((tmp_path / name / 'tracks.txt').read_bytes() for name in 'ab')
    assert first == second


@pytest.mark.real_data
def test_a_trimmed_video_is_imported_whole(data_root, tmp_path):
    film = data_root.parent / 'faults' / 'video' / 'trim.mp4'
    if not film.is_file():
        pytest.skip('left out: no faults/video beside the real data')
    done = run('import-videos', tmp_path / 'bag', f'north={film}')
    assert done.exit_code == 0
    assert 'north: 125 images' in done.output
