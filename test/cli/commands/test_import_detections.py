"""Own detections, from text and bags to scores, by the commands as documented."""

import re

import numpy as np
import pytest
from typer.testing import CliRunner

from lens_cameras import SIZE, camera
from mctrack_ros.cli.main import app
from mctrack_ros.ground import write_calibration
from mctrack_ros.interfaces import ClassCode, Detections
from mctrack_ros.recording import BagReader

RATE, IMAGES = 10, 80
CAMERAS = {
    'north': camera(eye=(3.0, -30.0, 9.0), distortion=(-0.05, 0, 0, 0, 0)),
    'south': camera(
        eye=(-20.0, 30.0, 9.0), target=(0.0, 5.0, 0.0), distortion=(-0.05, 0, 0, 0, 0)
    ),
}
FORMATS = {'north': 'opencv', 'south': 'camera_info'}
PLACES = [(1, 0.0, 8.0), (2, 5.0, 14.0)]


def mctrack(*arguments, code=0):
    result = CliRunner().invoke(app, [*map(str, arguments)])
    assert result.exit_code == code, f'{result.output}{result.exception!r}'
    return result.output if code == 0 else str(result.exception)


def walk(index):
    """Return the true (id, x, y) of an image: the second one walks away in the last second."""
    shift = 0.1 * index
    return [(who, x + shift, y) for who, x, y in PLACES if who == 1 or index < IMAGES - 10]


def boxes(name, index):
    """Return the (left, top, width, height) of those whom a camera sees."""
    mapping = CAMERAS[name]
    place = np.array([row[1:] for row in walk(index)])
    away = place - mapping.camera_position[:2]
    toes = mapping.image_from_ground(place - 0.13 * away / np.linalg.norm(away, axis=1)[:, None])
    foot, head = mapping.image_from_ground(place), mapping.image_from_ground(place, 1.7)
    height = toes[:, 1] - head[:, 1]
    left = (foot[:, 0] + head[:, 0]) / 2 - 0.2 * height
    return np.column_stack([left, head[:, 1], 0.4 * height, height]).round(1).tolist()


@pytest.fixture(scope='module')
def hall(tmp_path_factory):
    """Return a folder with a site, boxes of both cameras, and the truth."""
    folder = tmp_path_factory.mktemp('hall')
    for name, mapping in CAMERAS.items():
        write_calibration(mapping, folder / f'{name}.yaml', FORMATS[name], name)
    (folder / 'hall.yaml').write_text(
        'name: hall\nfusion: {batching: {period: 0.1}}\nfeedback_delay: 0.2\ncameras:\n'
        + ''.join(
            f'  {name}: {{calibration: {name}.yaml, image_width: {SIZE[0]}, '
            f'image_height: {SIZE[1]}}}\n'
            for name in CAMERAS
        )
    )
    mot, table = [], ['time,left,top,width,height,confidence,label']
    truth, text = ['time,id,x,y,class'], []
    for index in range(IMAGES):
        for left, top, width, height in boxes('north', index):
            mot.append(f'{index + 1},-1,{left},{top},{width},{height},0.9,-1,-1,-1')
        for left, top, width, height in boxes('south', index) if index % 10 else []:
            table.append(f'{(index + 0.5) / RATE},{left},{top},{width},{height},0.8,person')
        for who, x, y in walk(index):
            truth.append(f'{(index + 0.5) / RATE},{who},{x},{y},person')
            text.append(f'{index + 1},{who},-1,-1,-1,-1,1,{x},{y},0')
    for name, lines in (
        ('north.txt', mot), ('south.csv', table), ('truth.csv', truth), ('truth.txt', text)
    ):  # fmt: skip
        (folder / name).write_text('\n'.join(lines) + '\n')
    return folder


@pytest.fixture(scope='module')
def imported(hall):
    """Return what the import said; the bag is ``seen``, the tracks are in ``out``."""
    said = mctrack(
        *('import-detections', hall / 'seen', f'north={hall / "north.txt"}'),
        *(f'south={hall / "south.csv"}', '--site', hall / 'hall.yaml', '--rate', RATE),
    )
    mctrack('track', hall / 'seen', '--site', hall / 'hall.yaml', '--out', hall / 'out')
    return said


def detections_of(bag, name):
    with BagReader(bag) as reader:
        return [rows for rows, _ in reader.rows(f'/{name}/detections', Detections)]


def score(*arguments):
    """Return the figures that evaluate prints."""
    lines = re.findall(r'^  (\w+) +(-?[\d.]+|nan)$', mctrack('evaluate', *arguments), re.MULTILINE)
    return {name: float(value) for name, value in lines}


def test_every_image_has_a_message_and_boxes_stand_where_people_do(hall, imported):
    assert 'north: 150 detections of 150 in 80 images, 0 of them empty' in imported
    assert 'south: 135 detections of 135 in 80 images, 8 of them empty' in imported
    for name in CAMERAS:
        messages = detections_of(hall / 'seen', name)
        assert len({rows.stamp_ns for rows in messages}) == IMAGES
        for index in range(1, IMAGES, 7):
            true = np.array([row[1:] for row in walk(index)])
            found = messages[index]
            if len(found):
                np.testing.assert_allclose(found.position[:, :2], true, atol=0.3)
            assert (found.class_id == ClassCode.PERSON).all()


def test_the_bag_is_tracked_and_scored_by_bag_table_and_text_alike(hall, imported):
    of_bag = score(hall / 'truth.csv', hall / 'out')
    assert of_bag['mota'] > 0.9
    assert of_bag['idf1'] > 0.95
    assert of_bag['truth_ids'] == 2
    for truth in ('truth.csv', 'truth.txt'):
        for tracks in ('tracks.csv', 'tracks.txt', 'bag'):
            figures = score(hall / truth, hall / 'out' / tracks, '--rate', RATE)
            assert figures == pytest.approx(of_bag, abs=2e-3), (truth, tracks)


def test_an_area_counts_truth_and_tracks_inside_it_alike(hall, imported):
    whole = score(hall / 'truth.csv', hall / 'out')
    near = score(hall / 'truth.csv', hall / 'out', '--area=-1,7,30,9')
    assert near['truth_ids'] == 1
    assert near['truth_rows'] == IMAGES
    assert near['track_rows'] < whole['track_rows']
    assert near['false_positives'] == 0
    polygon = '--area=-1,7,30,7,30,9,-1,9'
    assert score(hall / 'truth.csv', hall / 'out', polygon) == near


def test_a_span_counts_from_its_beginning_until_before_its_end(hall, imported):
    for tracks in ('bag', 'tracks.txt'):
        figures = score(
            *(hall / 'truth.txt', hall / 'out' / tracks, '--from', 2, '--to', 7.1),
            *('--rate', RATE),
        )
        assert figures['frames'] == 51, tracks
        assert figures['truth_rows'] == 101, tracks  # the second one has gone in the last frame


def test_a_class_counts_the_tracks_of_which_it_is_said(hall, imported):
    whole = score(hall / 'truth.csv', hall / 'out')
    for tracks in ('bag', 'tracks.csv'):
        assert score(hall / 'truth.csv', hall / 'out' / tracks, '--class', 'person') == whole
    said = mctrack('evaluate', hall / 'truth.txt', hall / 'out', '--class', 'person')
    assert 'the truth says no classes: all of it is taken for person' in said
    refused = mctrack(
        *('evaluate', hall / 'truth.csv', hall / 'out' / 'tracks.txt', '--class', 'person'), code=1
    )
    assert 'does not say the class of its tracks: give the bag, or the tracks.csv' in refused
    nobody = mctrack('evaluate', hall / 'truth.csv', hall / 'out', '--class', 'vehicle', code=1)
    assert 'no truth is left by --class vehicle' in nobody


@pytest.mark.parametrize(
    ('options', 'said'),
    [
        (['--area', '1,2,3'], 'area is .*, expected x0,y0,x1,y1'),
        (['--from', '3', '--to', '2'], '--from 3 is not before --to 2'),
        (['--class', 'dog'], "--class is 'dog', expected one of unknown, person"),
        (['--area', '500,500,501,501'], 'no truth is left by --area=500,500,501,501'),
    ],
)
def test_what_selects_nothing_is_refused(hall, imported, options, said):
    refused = mctrack('evaluate', hall / 'truth.csv', hall / 'out', *options, code=1)
    assert re.search(said, refused)


def test_truth_of_score_zero_is_not_to_be_found_and_not_wrong(hall, imported, tmp_path):
    lines = (hall / 'truth.txt').read_text().splitlines()
    ignored = [line.replace(',-1,1,', ',-1,0,') if ',2,-1' in line else line for line in lines]
    (tmp_path / 'truth.txt').write_text('\n'.join(ignored))
    figures = score(tmp_path / 'truth.txt', hall / 'out')
    assert figures['truth_rows'] == IMAGES
    assert figures['false_positives'] <= score(hall / 'truth.txt', hall / 'out')['false_positives']


def test_tables_that_do_not_say_when_the_recording_began_need_frames(hall, imported, tmp_path):
    lines = (hall / 'out' / 'tracks.csv').read_text().splitlines()
    without = [','.join([time, *rest]) for time, _, *rest in (line.split(',') for line in lines)]
    (tmp_path / 'tracks.csv').write_text('\n'.join(without))
    refused = mctrack('evaluate', hall / 'truth.txt', tmp_path / 'tracks.csv', code=1)
    assert 'has times since 1970 and the other file has not: give it a column frame' in refused
    assert score(hall / 'out', tmp_path / 'tracks.csv')['mota'] == 1.0


def test_what_is_left_out_is_counted_and_said(hall, tmp_path):
    person = ','.join(map(str, boxes('north', 0)[0]))
    (tmp_path / 'north.csv').write_text(
        'frame,left,top,width,height,score,class,shoe\n'
        f'1,{person},0.9,person,7\n1,{person},0.1,person,7\n1,{person},1,Chair,7\n'
        f'1,{person},1,cat,7\n2,300,1,20,40,1,person,7\n3,900,300,20,40,1,person,7\n'
    )
    said = mctrack(
        *('import-detections', tmp_path / 'bag', f'north={tmp_path / "north.csv"}'),
        *('--site', hall / 'hall.yaml', '--rate', 10, '--least-score', 0.5),
        *('--class', 'cat=unknown'),
    )
    assert 'north: 2 detections of 6 in 3 images, 2 of them empty' in said
    assert 'north: 1 left out, their feet are not on ground' in said
    assert f'1 left out, outside the image (are they of images of {SIZE[0]} x' in said
    assert 'north: 1 left out, their score is below --least-score' in said
    assert 'north: 1 of class Chair left out (--class Chair=person?)' in said
    assert 'north: columns not read: shoe' in said
    assert 'south of hall is not in the bag' in said
    rows = detections_of(tmp_path / 'bag', 'north')[0]
    assert rows.class_id.tolist() == [ClassCode.PERSON, ClassCode.UNKNOWN]


def test_detectors_that_count_and_score_otherwise_are_imported_together(hall, tmp_path):
    for name, first, most in (('north', 0, 100), ('south', 1, 1)):
        lines = [
            f'{index + first},-1,{",".join(map(str, box))},{0.75 * most}'
            for index in range(9)
            for box in boxes(name, index)
        ]
        (tmp_path / f'{name}.txt').write_text('\n'.join(lines))
    sources = [f'{name}={tmp_path / name}.txt' for name in CAMERAS]
    site = ('--site', hall / 'hall.yaml', '--rate', RATE)
    for_all = ('--first-frame', 0, '--score-range', '0,100')
    one = ('--first-frame', 'north=0', '--score-range', 'north=0,100')
    other = ('--first-frame', 'south=1', '--score-range', 'south=0,1')
    for number, options in enumerate([one, for_all + other]):
        bag = tmp_path / f'bag{number}'
        mctrack('import-detections', bag, *sources, *site, *options)
        for name in CAMERAS:
            messages = detections_of(bag, name)
            first_ns = messages[0].stamp_ns
            assert first_ns % 1_000_000_000 == 50_000_000
            assert [rows.stamp_ns - first_ns for rows in messages] == [
                100_000_000 * index for index in range(9)
            ]
            assert {score for rows in messages for score in rows.score.tolist()} == {0.75}
    refused = mctrack(
        *('import-detections', tmp_path / 'no', f'north={tmp_path / "bag0"}', *site, *one[2:]),
        code=1,
    )
    assert 'bag0 is a bag: --score-range is for texts' in refused


@pytest.mark.parametrize(
    ('source', 'options', 'said'),
    [
        ('east={}', [], r'east is no camera of the site hall: they are north, south'),
        ('north={}', ['--later', 'south=1'], r'--later names south, expected one of north'),
        ('north={}', ['--score-range', '1'], r"--score-range is '1', expected LOW,HIGH"),
        ('north={}', ['--score-range', 'north=1'], r"--score-range is '1', expected LOW,HIGH"),
        ('north={}', ['--score-range', 'south=0,9'], r'--score-range names south, expected one'),
        (
            'north={}',
            ['--first-frame', '0', '--first-frame', '2'],
            r'--first-frame is given twice without a camera: 0, 2',
        ),
        ('north={}', ['--first-frame', 'north=-1'], r"--first-frame is '-1', expected a whole"),
        ('north={}', ['--class', 'car'], r"--class has 'car', expected a name and one of"),
        ('north={}', [], r'class 0 is a number: say what it is, --class 0=person'),
        ('north={}.absent', [], r'absent cannot be read: No such file'),
        ('{}', [], r'expected a camera and its value, for example north=north\.txt'),
    ],
)
def test_what_cannot_be_imported_is_refused_and_leaves_no_bag(
    hall, tmp_path, source, options, said
):
    (tmp_path / 'cam.csv').write_text('time,left,top,width,height,score,class\n1,1,2,30,80,1,0\n')
    refused = mctrack(
        *('import-detections', tmp_path / 'bag', source.format(tmp_path / 'cam.csv')),
        *('--site', hall / 'hall.yaml', *options),
        code=1,
    )
    assert re.search(said, refused)
    assert '\n' not in refused
    assert not (tmp_path / 'bag').exists()
