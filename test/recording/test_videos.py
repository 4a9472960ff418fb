import cv2
import numpy as np
import pytest

from mctrack_ros.codec import image_from_message, stamp_ns_of
from mctrack_ros.recording import BagReader
from mctrack_ros.recording.videos import START_NS, VideoError, open_video, write_videos

SIZE = (64, 48)


def film(path, count, rate=25.0):
    """Write a video of ever brighter pictures."""
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*'MJPG'), rate, SIZE)
    for index in range(count):
        writer.write(np.full((SIZE[1], SIZE[0], 3), 20 * (index % 12), np.uint8))
    writer.release()
    return path


def test_a_video_says_how_large_and_how_fast_it_is(tmp_path):
    video = open_video(film(tmp_path / 'north.avi', 5, rate=50.0))
    assert (video.size, video.rate_hz, video.stated) == (SIZE, 50.0, 5)
    assert open_video(video.path, 30.0).rate_hz == 30.0


def test_pictures_of_all_cameras_are_stamped_in_the_middle_of_their_periods(tmp_path):
    videos = {
        'north': open_video(film(tmp_path / 'north.avi', 4)),
        'south': open_video(film(tmp_path / 'south.avi', 3), later_s=0.08),
    }
    assert write_videos(videos, tmp_path / 'bag') == {'north': 4, 'south': 3}
    with BagReader(tmp_path / 'bag') as bag:
        found = [(topic, stamp_ns_of(m), image_from_message(m)) for topic, m, _ in bag.messages()]
    stamps = {'north': [20, 60, 100, 140], 'south': [100, 140, 180]}
    for name, expected in stamps.items():
        rows = [row for row in found if row[0] == f'/{name}/image_raw/compressed']
        assert [(stamp - START_NS) / 1e6 for _, stamp, _ in rows] == expected
        levels = [picture.mean() for *_, picture in rows]
        assert levels == pytest.approx([20 * i for i in range(len(rows))], abs=2)
    assert [stamp for _, stamp, _ in found] == sorted(stamp for _, stamp, _ in found)


def test_what_is_no_whole_video_is_refused(tmp_path):
    (tmp_path / 'text.avi').write_text('no video')
    with pytest.raises(VideoError, match='does not exist'):
        open_video(tmp_path / 'none.avi')
    with pytest.raises(VideoError, match='no video that OpenCV reads'):
        open_video(tmp_path / 'text.avi')
    path = film(tmp_path / 'north.avi', 60)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with pytest.raises(VideoError, match=r'north\.avi'):
        write_videos({'north': open_video(path)}, tmp_path / 'bag')
