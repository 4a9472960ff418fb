import pytest

from films import SIZE, cut, level_image, write_film, write_steady_film
from mctrack_ros.codec import image_from_message, stamp_ns_of
from mctrack_ros.recording import BagReader
from mctrack_ros.recording.video.videos import (
    START_NS,
    VideoError,
    open_video,
    strangers,
    together,
    write_videos,
)


def test_a_video_says_how_large_and_how_fast_it_is(tmp_path):
    video = open_video(write_steady_film(tmp_path / 'north.avi', 5, rate=50.0))
    assert (video.size, video.rate_hz, video.stated) == (SIZE, 50.0, 5)
    assert open_video(video.path, 30.0).rate_hz == 30.0


def test_images_of_all_cameras_are_stamped_in_the_middle_of_their_periods(tmp_path):
    videos = {
        'north': open_video(write_steady_film(tmp_path / 'north.avi', 4)),
        'south': open_video(write_steady_film(tmp_path / 'south.avi', 3), later_s=0.08),
    }
    assert write_videos(videos, tmp_path / 'bag') == {'north': 4, 'south': 3}
    with BagReader(tmp_path / 'bag') as bag:
        found = [(topic, stamp_ns_of(m), image_from_message(m)) for topic, m, _ in bag.messages()]
    stamps = {'north': [20, 60, 100, 140], 'south': [100, 140, 180]}
    for name, expected in stamps.items():
        rows = [row for row in found if row[0] == f'/{name}/image_raw/compressed']
        assert [(stamp - START_NS) / 1e6 for _, stamp, _ in rows] == expected
        levels = [image.mean() for *_, image in rows]
        assert levels == pytest.approx([level_image(i).mean() for i in range(len(rows))], abs=2)
    assert [stamp for _, stamp, _ in found] == sorted(stamp for _, stamp, _ in found)


def test_a_video_that_breaks_off_is_an_error_and_the_bag_holds_what_was_read(tmp_path):
    path = cut(write_steady_film(tmp_path / 'north.avi', 60), 0.5)
    with pytest.raises(VideoError, match=r'north\.avi breaks off after \d+ images.*holds what'):
        write_videos({'north': open_video(path)}, tmp_path / 'bag')
    with BagReader(tmp_path / 'bag') as bag:
        assert bag.count('/north/image_raw/compressed') > 15


def test_the_first_image_of_all_lies_half_the_shortest_period_after_the_start(tmp_path):
    late = [100.0, 100.1, 100.2]
    videos = {
        'north': open_video(write_film(tmp_path / 'north.mp4', late)),
        'south': open_video(write_steady_film(tmp_path / 'south.avi', 3, rate=50.0), 0.0, 101.0),
    }
    stamps = {
        name: [stamp_ns for *_, stamp_ns in source.messages(source.reading())]
        for name, source in together(videos).items()
    }
    assert [(ns - START_NS) / 1e6 for ns in stamps['north']] == pytest.approx([10, 110, 210])
    assert [(ns - START_NS) / 1e6 for ns in stamps['south']] == pytest.approx([1010, 1030, 1050])


def test_videos_that_share_no_time_are_named(tmp_path):
    north = open_video(write_steady_film(tmp_path / 'north.avi', 25))
    south = open_video(write_steady_film(tmp_path / 'south.avi', 25), later_s=3600.0)
    assert not strangers({'north': north, 'other': north})
    (line,) = strangers({'north': north, 'south': south})
    assert line.startswith('south begins at 3600.00 s, after the end of north at 1.00 s')


def test_what_a_file_leaves_open_is_told(tmp_path):
    gap = open_video(write_film(tmp_path / 'north.mp4', [0.0, 0.04, 60.0, 60.04]))
    told = []
    assert write_videos({'north': gap}, tmp_path / 'bag', tell=told.append) == {'north': 4}
    assert len(told) == 1
    assert 'north.mp4: its times leap' in told[0]
