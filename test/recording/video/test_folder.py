"""A folder of images is a video."""

import cv2
import numpy as np
import pytest

from films import level_image
from mctrack_ros.recording.video.videos import VideoError, open_video, together, write_videos

SIZE = (64, 48)


def write(folder, *names):
    folder.mkdir(exist_ok=True)
    for index, name in enumerate(names):
        cv2.imwrite(str(folder / name), level_image(index, SIZE))
    return folder


def levels(video):
    reading = video.reading()
    found = [(time_s, float(image.mean())) for time_s, image in reading]
    return found, reading


@pytest.mark.parametrize(
    'names',
    [
        ('1700000005.0.png', '1700000005.04.png', '1700000005.12.png'),
        ('1700000005000.png', '1700000005040.png', '1700000005120.png'),
        ('1700000005000000000.jpg', '1700000005040000000.jpg', '1700000005120000000.jpg'),
    ],
)
def test_names_are_times(tmp_path, names):
    video = open_video(write(tmp_path / 'north', *names))
    assert video.size == SIZE
    assert video.length_s == pytest.approx(0.12 + 0.06, abs=1e-5)
    found, reading = levels(video)
    assert [time_s for time_s, _ in found] == pytest.approx(
        1_700_000_005 + np.array([0.0, 0.04, 0.12]), abs=1e-6
    )
    assert [level for _, level in found] == sorted(level for _, level in found)
    assert (reading.count, reading.notes(), reading.fault()) == (3, [], '')


def test_folders_of_several_cameras_keep_their_common_time(tmp_path):
    videos = {
        'north': open_video(write(tmp_path / 'north', '1700000005.0.png', '1700000005.1.png')),
        'south': open_video(write(tmp_path / 'south', '1700000005.05.png', '1700000005.15.png')),
    }
    sources = together(videos)
    stamps = {
        name: [stamp for _, _, stamp in source.messages(source.reading())]
        for name, source in sources.items()
    }
    assert stamps['south'][0] - stamps['north'][0] == pytest.approx(50_000_000, abs=1000)
    assert write_videos(videos, tmp_path / 'bag') == {'north': 2, 'south': 2}


def test_frame_numbers_need_a_rate(tmp_path):
    folder = write(tmp_path / 'north', 'frame_2.jpg', 'frame_10.jpg', 'frame_1.jpg')
    with pytest.raises(VideoError, match='does not say when it was taken: give the rate'):
        open_video(folder)
    found, _ = levels(open_video(folder, rate_hz=10.0))
    assert [time_s for time_s, _ in found] == pytest.approx([0.0, 0.1, 0.2])
    assert [level for _, level in found] == pytest.approx([40, 20, 30], abs=2)


def test_what_is_no_image_is_left_out_and_said(tmp_path):
    folder = write(tmp_path / 'north', '1.0.png', '2.0.png', '3.0.png')
    (folder / 'notes.txt').write_text('not an image')
    (folder / '2.0.png').write_bytes(b'not an image')
    cv2.imwrite(str(folder / '3.0.png'), np.zeros((20, 20, 3), np.uint8))
    found, reading = levels(open_video(folder))
    assert [time_s for time_s, _ in found] == [1.0]
    assert [line.split(': ', 1)[1] for line in reading.notes()] == [
        'images left out that cannot be decoded: 1',
        'images left out that have another size: 1',
    ]
    empty = tmp_path / 'empty'
    empty.mkdir()
    with pytest.raises(VideoError, match='holds no images'):
        open_video(empty)
    (empty / '1.0.png').write_bytes(b'no image')
    with pytest.raises(VideoError, match='holds no images that can be decoded'):
        open_video(empty)
