import struct

import av
import cv2
import numpy as np
import pytest

from films import SIZE, cut, level_image, write_film, write_steady_film
from mctrack_ros.recording.video.file import VideoError, VideoReading
from mctrack_ros.recording.video.videos import open_video

FAULTS = 'faults/video'
UNEVEN_S = [0.0, 0.04, 0.08, 0.2, 0.32, 0.44, 0.48, 0.52]
STEADY_S = [index / 25 for index in range(60)]


def noise_images(count):
    rng = np.random.default_rng(1)
    noise = rng.integers(0, 256, (count, SIZE[1], SIZE[0], 3), np.uint8)
    return [cv2.GaussianBlur(image, (5, 5), 0) for image in noise]


def read(video):
    """Return the times (s), the mean brightness of the images and the reading."""
    reading = VideoReading(video)
    found = list(reading)
    times = np.array([time_s for time_s, _ in found])
    return times, [image.mean() for _, image in found], reading


@pytest.fixture
def faults(data_root):
    """Return the folder of films of real kinds."""
    folder = data_root.parent / FAULTS
    if not folder.is_dir():
        pytest.skip(f'left out: no {FAULTS} beside the real data')
    return folder


@pytest.mark.parametrize('kind', ['mp4', 'mkv', 'ts', 'flv', 'mov'])
def test_images_have_the_times_that_the_file_states(tmp_path, kind):
    video = open_video(write_film(tmp_path / f'film.{kind}', UNEVEN_S))
    times, levels, reading = read(video)
    np.testing.assert_allclose(times, UNEVEN_S, atol=1e-3)
    expected = [level_image(index).mean() for index in range(len(UNEVEN_S))]
    assert levels == pytest.approx(expected, abs=5)
    assert not reading.notes()
    assert not reading.fault()


def test_a_given_rate_goes_before_the_times_of_the_file(tmp_path):
    video = open_video(write_film(tmp_path / 'film.mp4', UNEVEN_S), rate_hz=10.0)
    np.testing.assert_allclose(read(video)[0], np.arange(8) / 10)


def test_a_film_that_begins_later_on_its_time_line_says_so(tmp_path):
    later = [1.5 + time_s for time_s in STEADY_S]
    video = open_video(write_film(tmp_path / 'film.mp4', later))
    times, _, reading = read(video)
    assert video.start_s == pytest.approx(1.5)
    assert times[0] == pytest.approx(1.5)
    assert not reading.fault()


def test_a_transport_stream_counts_from_its_first_packet(tmp_path):
    late = [3600.0 + time_s for time_s in STEADY_S]
    video = open_video(write_film(tmp_path / 'film.ts', late))
    np.testing.assert_allclose(read(video)[0], STEADY_S, atol=1e-3)


def test_a_wait_for_reordered_images_is_no_later_start(tmp_path):
    options = {'movflags': 'frag_keyframe+empty_moov'}
    video = open_video(write_film(tmp_path / 'film.mp4', STEADY_S, **options))
    with av.open(str(video.path)) as container:
        assert container.streams.video[0].start_time > 0
    np.testing.assert_allclose(read(video)[0], STEADY_S, atol=1e-3)


@pytest.mark.parametrize('kind', ['h264', 'mjpeg'])
def test_a_film_without_times_asks_for_a_rate(tmp_path, kind):
    codec = 'mjpeg' if kind == 'mjpeg' else 'libx264'
    path = write_film(tmp_path / f'film.{kind}', STEADY_S, codec=codec)
    with pytest.raises(VideoError, match=r'does not say when .*--rate'):
        open_video(path)
    times, _, reading = read(open_video(path, rate_hz=25.0))
    np.testing.assert_allclose(times, STEADY_S)
    assert not reading.fault()


@pytest.mark.parametrize(('kind', 'options'), [('mp4', {'movflags': 'faststart'}), ('mkv', {})])
def test_a_file_that_was_cut_off_is_read_to_there_and_says_so(tmp_path, kind, options):
    images = noise_images(60)
    path = cut(write_film(tmp_path / f'film.{kind}', STEADY_S, images, **options), 0.6)
    times, _, reading = read(open_video(path))
    assert 20 < len(times) < 50
    assert (np.abs(times[:, None] - STEADY_S).min(axis=1) < 1e-3).all()
    assert f'breaks off after {len(times)} images' in reading.fault()
    assert 'film' in reading.fault()


def test_an_avi_file_with_reordered_images_keeps_each_of_them_at_its_time(tmp_path):
    """AVI says when images are decoded, which is not the order in which they are shown."""
    rng = np.random.default_rng(4)
    scene = rng.integers(0, 255, (48, 64, 3)).astype(np.uint8)
    shown = [cv2.blur(np.roll(scene, index, axis=1), (5, 5)) for index in range(60)]
    path = write_film(tmp_path / 'film.avi', np.arange(60) / 25, shown, time_base=25)
    reading = VideoReading(open_video(path))
    times, images = zip(*reading)
    np.testing.assert_allclose(times, np.arange(60) / 25, atol=1e-9)
    wrong = [
        index
        for index, image in enumerate(images)
        if min(range(60), key=lambda other: np.abs(image - shown[other].astype(int)).sum())
        != index
    ]
    assert not wrong
    assert not reading.notes() + [reading.fault()] * bool(reading.fault())


def test_a_cut_avi_file_says_how_many_bytes_are_missing(tmp_path):
    path = cut(write_steady_film(tmp_path / 'film.avi', 60), 0.5)
    times, _, reading = read(open_video(path))
    assert 15 < len(times) < 40
    assert 'bytes are there' in reading.fault()


def test_the_count_in_a_header_is_only_an_estimate(tmp_path):
    path = write_steady_film(tmp_path / 'film.avi', 30)
    data = bytearray(path.read_bytes())
    for at in (data.index(b'avih') + 8 + 16, data.index(b'strh') + 8 + 32):
        assert struct.unpack_from('<I', data, at) == (30,)
        struct.pack_into('<I', data, at, 90)
    path.write_bytes(data)
    times, _, reading = read(open_video(path))
    assert len(times) == 30
    assert not reading.fault()


def test_a_damaged_image_is_left_out_and_the_others_keep_their_times(tmp_path):
    path = write_film(tmp_path / 'film.mkv', STEADY_S, codec='mjpeg')
    data = bytearray(path.read_bytes())
    starts = [at for at in range(len(data) - 3) if data[at : at + 3] == b'\xff\xd8\xff']
    data[starts[30] : starts[31] - 40] = bytes(starts[31] - 40 - starts[30])
    path.write_bytes(data)
    times, _, reading = read(open_video(path))
    np.testing.assert_allclose(times, np.delete(STEADY_S, 30), atol=1e-3)
    assert 'cannot be decoded: 1' in reading.notes()[0]
    assert not reading.fault()


@pytest.mark.parametrize(
    ('angle', 'turned', 'corner'),
    [(90, (48, 64), (0, -1)), (180, (64, 48), (-1, -1)), (270, (48, 64), (-1, 0))],
)
def test_a_film_is_turned_clockwise_as_it_asks(tmp_path, angle, turned, corner):
    image = np.full((SIZE[1], SIZE[0], 3), 40, np.uint8)
    image[:24, :32] = 220
    path = write_film(tmp_path / 'film.mp4', STEADY_S, [image] * 60)
    data = bytearray(path.read_bytes())
    cos, sin = round(np.cos(np.radians(angle))), round(np.sin(np.radians(angle)))
    matrix = [cos * 65536, sin * 65536, 0, -sin * 65536, cos * 65536, 0, 0, 0, 1 << 30]
    struct.pack_into('>9i', data, data.index(b'tkhd') + 4 + 40, *matrix)
    path.write_bytes(data)
    video = open_video(path)
    assert video.size == turned
    first = next(iter(video.images()))
    assert first.shape == (turned[1], turned[0], 3)
    corners = {(y, x): first[y, x].mean() for y in (0, -1) for x in (0, -1)}
    assert max(corners, key=lambda where: corners[where]) == corner


def test_images_are_those_that_opencv_decodes(tmp_path):
    path = write_film(tmp_path / 'film.mp4', UNEVEN_S, noise_images(8))
    capture = cv2.VideoCapture(str(path))
    for image in open_video(path).images():
        np.testing.assert_array_equal(image, capture.read()[1])


def test_images_of_another_size_than_the_first_are_left_out(tmp_path):
    small = write_film(tmp_path / 'small.ts', STEADY_S)
    large = [level_image(index, (96, 72)) for index in range(60)]
    late = [3.0 + time_s for time_s in STEADY_S]
    data = write_film(tmp_path / 'large.ts', late, large).read_bytes()
    (tmp_path / 'film.ts').write_bytes(small.read_bytes() + data)
    times, _, reading = read(open_video(tmp_path / 'film.ts'))
    assert len(times) == 60
    assert 'another size: 60' in reading.notes()[0]


def test_what_is_no_video_is_refused(tmp_path):
    with pytest.raises(VideoError, match='holds no images'):
        open_video(tmp_path)
    (tmp_path / 'text.avi').write_text('no video')
    with pytest.raises(VideoError, match='does not exist'):
        open_video(tmp_path / 'none.avi')
    with pytest.raises(VideoError, match='no video that can be read'):
        open_video(tmp_path / 'text.avi')


@pytest.mark.real_data
def test_a_trimmed_file_is_whole(faults):
    times, _, reading = read(open_video(faults / 'trim.mp4'))
    np.testing.assert_allclose(times, np.arange(125) / 25, atol=1e-4)
    assert not reading.notes()
    assert not reading.fault()


@pytest.mark.real_data
@pytest.mark.parametrize('name', ['north_slow', 'south_full'])
def test_a_film_whose_rate_changes_keeps_its_times(faults, name):
    times, _, reading = read(open_video(faults / f'{name}.mp4'))
    np.testing.assert_allclose(times, np.loadtxt(faults / f'{name}.pts.txt'), atol=1e-4)
    assert not reading.fault()
