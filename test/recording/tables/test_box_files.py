import numpy as np
import pytest

from mctrack_ros.recording.tables.box_files import TextClock, read_boxes
from mctrack_ros.recording.tables.columns import TableError
from mctrack_ros.recording.tables.sightings import with_all_images
from mctrack_ros.recording.video.videos import START_NS

TEN_HZ = TextClock(rate_hz=10.0)


def read(folder, text, clock=TEN_HZ):
    path = folder / 'boxes.csv'
    path.write_text(text)
    return read_boxes(path, clock)


@pytest.mark.parametrize(
    'text',
    [
        '3,-1,10,20,30,40,0.5\n1,-1,1,2,30,80,0.9,-1,-1,-1\n',
        '3 -1 1.0e1 20 30 40 .5 -1 -1 -1 -1\n\n1 -1 1 2 30 80 .9 -1 -1 -1 -1\n',
        'frame,left,top,width,height,score\n3,10,20,30,40,0.5\n1,1,2,30,80,0.9\n',
        '\ufeffConfidence;Frame;x1;y1;x2;y2\n0.5;3;10;20;40;60\n0.9;1;1;2;31;82\n',
        'frame\tcx\tcy\tw\th\tconf\tarea\n3\t25\t40\t30\t40\t0.5\t7\n1\t16\t42\t30\t80\t0.9\t7\n',
        'frame, bb_left, bb_top, right [px], bottom [px], prob\n'
        '3, 10, 20, 40, 60, 0.5\n1, 1, 2, 31, 82, 0.9\n',
        'time,left,top,width,height,score\n0.05,1,2,30,80,0.9\n0.25,10,20,30,40,0.5\n',
        'time_ms,left,top,width,height,score\n50,1,2,30,80,0.9\n250,10,20,30,40,0.5\n',
        'stamp_ns,left,top,width,height,score\n'
        f'{START_NS + 50_000_000},1,2,30,80,0.9\n{START_NS + 250_000_000},10,20,30,40,0.5\n',
    ],
)
def test_boxes_are_read_from_every_usual_text(text, tmp_path):
    seen = with_all_images({'cam': read(tmp_path, text)})['cam']
    assert (seen.stamp_ns - START_NS).tolist() == [50_000_000, 150_000_000, 250_000_000]
    assert seen.image.tolist() == [0, 2]
    assert seen.box.tolist() == [[1, 2, 30, 80], [10, 20, 30, 40]]
    assert seen.score.tolist() == [0.9, 0.5]
    assert np.isnan(seen.position).all()
    assert seen.local_id.tolist() == [0, 0]


def test_places_classes_and_ids_are_read_beside_boxes(tmp_path):
    text = (
        'time,ground_x,ground_y,sigma,left,top,width,height,score,class,track_id\n'
        '1.0,1.5,-2,0.1,,,,,1,person,A\n1.0,,,,5,6,7,8,0.5,Car,0\n1.5,3,4,,,,,,1,person,A\n'
        '2.0,,,,,,,,,,\n'
    )
    seen = read(tmp_path, text)
    assert len(seen.stamp_ns) == 3  # nothing was seen in the last image
    np.testing.assert_equal(seen.position, [[1.5, -2], [np.nan, np.nan], [3, 4]])
    assert seen.box[1].tolist() == [5, 6, 7, 8]
    np.testing.assert_equal(seen.sigma, [0.1, np.nan, np.nan])
    assert seen.label.tolist() == ['person', 'Car', 'person']
    assert seen.local_id.tolist() == [1, 2, 1]


def test_mot_text_tells_positions_where_its_boxes_are_minus_one_and_classes_of_mot16(tmp_path):
    seen = read(tmp_path, '1,7,-1,-1,-1,-1,0.5,3.5,-1,0\n1,8,1,2,3,4,-1,3,0.7\n')
    np.testing.assert_equal(seen.position, [[3.5, -1], [np.nan, np.nan]])
    assert seen.score.tolist() == [0.5, 1.0]  # -1: not told
    assert seen.label.tolist() == ['', 'car']
    assert seen.local_id.tolist() == [1, 2]


def test_scores_of_another_range_are_told_and_lie_within_it(tmp_path):
    text = 'frame,left,top,width,height,score\n1,1,2,30,80,-1\n2,1,2,30,80,80\n'
    with pytest.raises(TableError, match=r'line 2: the score is -1, .* --score-range=-1,80\?'):
        read(tmp_path, text)
    seen = read(tmp_path, text, TextClock(10.0, score_range=(-1.0, 161.0)))
    assert seen.score.tolist() == [0.0, 0.5]


def test_files_may_count_from_zero_and_begin_later(tmp_path):
    text = 'frame,left,top,width,height,score\n0,1,2,30,80,1\n'
    with pytest.raises(TableError, match=r'line 2: frame is 0.*--first-frame 0'):
        read(tmp_path, text)
    seen = read(tmp_path, text, TextClock(10.0, first_frame=0, later_s=2.0))
    assert (seen.stamp_ns - START_NS).tolist() == [2_050_000_000]


@pytest.mark.parametrize(
    ('text', 'said'),
    [
        ('', r'boxes\.csv is empty|holds no rows'),
        ('1,-1,ten,20,30,40,1\n', r"line 1: left is 'ten', expected a number"),
        ('\n\nframe,x,y,score\n1,a,2,1\n', r"line 4: x is 'a', expected a number"),
        ('1,-1,10,20,30,40\n', r'line 1: 6 fields, expected at least 7'),
        ('1,-1,10,20,30,-40,1\n', r'line 1: the box is 30 x -40 px, expected sizes above 0'),
        ('1,-1,10,20,30,40,1\n2,-1,nan,20,30,40,1\n', r'line 2: left is nan, expected a finite'),
        ('1.5,-1,10,20,30,40,1\n', r'line 1: frame is 1.5, expected a whole number from 1'),
        ('99999999,-1,10,20,30,40,1\n', r'99999999 images: is a frame or a time wrong'),
        ('1,-1,.1,.2,.3,.4,1\n', r'the boxes are shares of the image, expected pixels'),
        ('frame,left,top,width,height\n1,1,2,3,4\n', r'has no column score'),
        ('frame,score\n1,1\n', r'neither a box .* nor a position'),
        ('left,top,width,height,score\n1,2,3,4,1\n', r'has neither a column time nor frame'),
        (
            'frame,left,top,width,score\n1,1,2,3,1\n',
            r'top alone is no box: expected top and height',
        ),
        (
            'frame,x,y,width,height,score\n1,1,2,3,4,1\n',
            r'are x and y metres on the ground or pix',
        ),
        ('frame,x,score\n1,1,1\n', r'only one of the columns x and y'),
        ('frame,x,y,score\n1,1,,1\n', r'line 2: only one of x and y is filled in'),
        ('frame,x,y,score\n1,1,2\n', r'line 2: 3 fields, expected 4 as in the header'),
        ('frame,x,y,score\n1,1,2,\n', r'line 2: the score is empty'),
        ('frame,x,y,score,conf\n1,1,2,1,1\n', r'the columns score and conf stand for the same'),
        ('time,x,y,score\n2,1,2,1\n1,1,2,1\n', r'line 3: the time goes back'),
        ('time,x,y,score\nnoon,1,2,1\n', r"line 2: time is 'noon', expected a time"),
        ('time,x,y,score\n1,1,2,1\n1.7e9,1,2,1\n', r'line 3: the time counts from 1970, and in'),
        ('time,x,y,sigma,score\n1,1,2,0,1\n', r'line 2: sigma is 0 m, expected more than 0'),
        ('time,left,top,width,height,score\n1,1,,3,4,1\n', r'line 2: a part of the box is empty'),
    ],
)
def test_what_cannot_be_used_is_named_with_its_line(text, said, tmp_path):
    with pytest.raises(TableError, match=said) as refused:
        read(tmp_path, text)
    assert 'boxes.csv' in str(refused.value)
    assert '\n' not in str(refused.value)


def test_times_from_1970_cannot_be_moved(tmp_path):
    text = 'time,x,y,score\n1764000000.1,1,2,1\n'
    assert read(tmp_path, text).stamp_ns.tolist() == [1_764_000_000_100_000_000]
    with pytest.raises(TableError, match=r'count from 1970: --later cannot move them'):
        read(tmp_path, text, TextClock(later_s=1.0))


def test_frames_need_a_rate(tmp_path):
    with pytest.raises(TableError, match=r'counts frames: say by --rate'):
        read(tmp_path, '1,-1,10,20,30,40,1\n', TextClock())


def test_images_in_which_nothing_was_seen_are_added_up_to_what_any_camera_saw(tmp_path):
    header = 'time,x,y,score\n'
    north = read(tmp_path, header + '0.1,1,2,1\n0.21,1,2,1\n0.6,1,2,1\n', TextClock())
    south = read(tmp_path, header + '0.3,1,2,1\n0.4,1,2,1\n', TextClock())
    seen = with_all_images({'north': north, 'south': south})
    for each, images in (('north', [0, 1, 5]), ('south', [2, 3])):
        tenths = np.round((seen[each].stamp_ns - START_NS) / 1e8).astype(int)
        assert tenths.tolist() == [1, 2, 3, 4, 5, 6]
        assert seen[each].image.tolist() == images


def test_cameras_on_different_clocks_are_refused(tmp_path):
    own = read(tmp_path, 'time,x,y,score\n0.1,1,2,1\n')
    real = read(tmp_path, 'time,x,y,score\n1764000000.1,1,2,1\n')
    with pytest.raises(TableError, match=r'real begin .* after those of own: all .* one clock'):
        with_all_images({'own': own, 'real': real})
