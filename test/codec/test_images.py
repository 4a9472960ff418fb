import resource
import tracemalloc
import zlib
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from mctrack_ros.codec import (
    CodecError,
    compressed_message,
    image_from_message,
    image_message,
    jpeg_from_image,
    stamp_ns_of,
)
from mctrack_ros.recording import ROSBAGS_CLASSES
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES

BOTH = pytest.mark.parametrize(
    'classes', [RCLPY_CLASSES, ROSBAGS_CLASSES], ids=['rclpy', 'rosbags']
)


@BOTH
def test_raw_images_survive_the_round_trip(classes):
    image = np.random.default_rng(1).integers(0, 256, (6, 10, 3), np.uint8)
    message = image_message(image, classes, 3, 'cam1_optical_frame')
    assert stamp_ns_of(message) == 3
    np.testing.assert_array_equal(image_from_message(message), image)


@BOTH
def test_grey_images_come_back_with_three_channels_alike(classes):
    image = np.random.default_rng(1).integers(0, 256, (6, 10), np.uint8)
    message = image_message(image, classes, 3, 'cam1_optical_frame')
    assert (message.encoding, message.step, len(message.data)) == ('mono8', 10, 60)
    np.testing.assert_array_equal(image_from_message(message), np.dstack([image] * 3))


@BOTH
def test_compressed_images_come_back_alike(classes):
    column = np.linspace(0, 255, 64, dtype=np.uint8)
    image = np.repeat(np.tile(column, (48, 1))[:, :, None], 3, axis=2)
    message = compressed_message(jpeg_from_image(image), classes, 3, 'cam1_optical_frame')
    back = image_from_message(message)
    assert back.shape == image.shape
    assert np.abs(back.astype(int) - image).mean() < 3


@pytest.mark.parametrize(
    ('encoding', 'channels', 'code'),
    [
        ('mono8', 1, cv2.COLOR_GRAY2BGR),
        ('rgb8', 3, cv2.COLOR_RGB2BGR),
        ('bgra8', 4, cv2.COLOR_BGRA2BGR),
        ('rgba8', 4, cv2.COLOR_RGBA2BGR),
    ],
)
def test_other_encodings_become_bgr_and_row_padding_is_skipped(encoding, channels, code):
    image = np.random.default_rng(1).integers(0, 256, (4, 5, channels), np.uint8)
    step = 5 * channels + 3
    data = np.zeros((4, step), np.uint8)
    data[:, : 5 * channels] = image.reshape(4, -1)
    message = SimpleNamespace(encoding=encoding, height=4, width=5, step=step, data=data.tobytes())
    np.testing.assert_array_equal(image_from_message(message), cv2.cvtColor(image, code))


@pytest.mark.parametrize(
    ('changes', 'reason'),
    [
        ({'data': b''}, 'the image is empty'),
        ({'encoding': '32FC1'}, "encoding '32FC1' is not known"),
        ({'width': 7}, 'holds 60 bytes, expected 84'),
        ({'height': 5}, 'holds 60 bytes, expected 75'),
        ({'step': 1}, 'with step 1'),
        ({'width': 0, 'step': 0}, 'holds 60 bytes'),
    ],
)
def test_wrong_images_are_refused_with_the_reason(changes, reason):
    good = {'encoding': 'bgr8', 'height': 4, 'width': 5, 'step': 15, 'data': bytes(60)}
    with pytest.raises(CodecError, match=reason):
        image_from_message(SimpleNamespace(**(good | changes)))


COLOUR = (200, 120, 10)
"""Blue, green, red of what is mosaicked."""


def mosaic(pattern, values=COLOUR, shape=(8, 12), dtype=np.uint8):
    """Return what a sensor under a colour filter sees of one colour everywhere."""
    blue, green, red = values
    of = {'b': blue, 'g': green, 'r': red}
    tile = np.array([[of[c] for c in pattern[:2]], [of[c] for c in pattern[2:]]], dtype)
    return np.tile(tile, (shape[0] // 2, shape[1] // 2))


def raw(encoding, values, big=False, padding=0):
    """Return a message of (rows, values) of its data, and of the image's own size."""
    rows = [row.tobytes() + b'\x5a' * padding for row in values]
    return SimpleNamespace(
        encoding=encoding, step=len(rows[0]), data=b''.join(rows), is_bigendian=int(big)
    )


PATTERNS = pytest.mark.parametrize('pattern', ['rggb', 'bggr', 'gbrg', 'grbg'])


@PATTERNS
@pytest.mark.parametrize('padding', [0, 5])
def test_a_raw_mosaic_gets_its_colours(pattern, padding):
    message = raw(f'bayer_{pattern}8', mosaic(pattern), padding=padding)
    message.height, message.width = 8, 12
    np.testing.assert_array_equal(image_from_message(message), np.full((8, 12, 3), COLOUR))


@PATTERNS
@pytest.mark.parametrize('big', [False, True])
def test_a_mosaic_of_16_bits_is_scaled_over_the_whole_range(pattern, big):
    values = mosaic(pattern, [257 * value for value in COLOUR], dtype='>u2' if big else '<u2')
    message = raw(f'bayer_{pattern}16', values, big, padding=3)
    message.height, message.width = 8, 12
    np.testing.assert_array_equal(image_from_message(message), np.full((8, 12, 3), COLOUR))


@pytest.mark.parametrize(
    ('encoding', 'order'),
    [
        ('mono16', None),
        ('16UC1', None),
        ('bgr16', [0, 1, 2]),
        ('16UC3', [0, 1, 2]),
        ('rgb16', [2, 1, 0]),
        ('bgra16', [0, 1, 2, 3]),
        ('rgba16', [2, 1, 0, 3]),
    ],
)
@pytest.mark.parametrize('big', [False, True])
def test_16_bits_become_the_nearest_8(encoding, order, big):
    rng = np.random.default_rng(2)
    levels = rng.integers(0, 65536, (6, 10, 4))
    levels[0, :4, :3] = np.array([0, 65535, 128, 129])[:, None]
    right = np.floor(levels[..., :3] / 257 + 0.5).astype(np.uint8)
    stored = levels[..., order] if order else levels[..., :1]
    message = raw(encoding, stored.astype('>u2' if big else '<u2'), big, padding=4)
    message.height, message.width = 6, 10
    expected = right if order else np.repeat(right[..., :1], 3, axis=2)
    np.testing.assert_array_equal(image_from_message(message), expected)


@pytest.mark.parametrize(('encoding', 'channels'), [('8UC1', 1), ('8UC3', 3), ('8UC4', 4)])
def test_numbers_of_channels_without_a_name_are_grey_and_bgr(encoding, channels):
    values = np.random.default_rng(3).integers(0, 256, (6, 10, channels), np.uint8)
    message = raw(encoding, values, padding=2)
    message.height, message.width = 6, 10
    expected = np.repeat(values, 3, axis=2) if channels == 1 else values[..., :3]
    np.testing.assert_array_equal(image_from_message(message), expected)


def bgr_of(luma, blue, red):
    """Return BT.601's blue, green, red of studio luma and chroma."""
    y, u, v = 1.164 * (luma - 16.0), blue - 128.0, red - 128.0
    colours = [y + 2.018 * u, y - 0.391 * u - 0.813 * v, y + 1.596 * v]
    return np.clip(np.stack(colours, axis=-1), 0, 255)


@pytest.mark.parametrize('encoding', ['yuv422', 'uyvy', 'yuv422_yuy2', 'yuyv', 'nv21', 'nv24'])
@pytest.mark.parametrize('padding', [0, 6])
def test_luma_and_chroma_become_the_colours_of_bt_601(encoding, padding):
    rng = np.random.default_rng(4)
    luma = rng.integers(16, 236, (8, 12), np.uint8)
    across, down = {'nv21': (2, 2), 'nv24': (1, 1)}.get(encoding, (2, 1))
    chroma = rng.integers(60, 200, (8 // down, 12 // across, 2), np.uint8)
    blue, red = chroma.repeat(down, 0).repeat(across, 1).transpose(2, 0, 1)
    if encoding == 'nv21':
        rows = list(np.vstack([luma, chroma[..., ::-1].reshape(4, 12)]))
    elif encoding == 'nv24':
        rows = list(np.vstack([luma, chroma.reshape(16, 12)]))
    else:
        halves = np.stack([chroma[..., 0], chroma[..., 1]], axis=2).reshape(8, 12)
        pair = (luma, halves) if encoding in ('yuyv', 'yuv422_yuy2') else (halves, luma)
        rows = list(np.stack(pair, axis=2))
    message = raw(encoding, rows, padding=padding)
    message.height, message.width = 8, 12
    found = image_from_message(message).astype(float)
    assert np.abs(found - bgr_of(luma.astype(float), blue, red)).max() < 2.5


@pytest.mark.parametrize(('encoding', 'width'), [('yuyv', 5), ('uyvy', 7), ('nv21', 9)])
def test_halved_chroma_needs_even_sizes(encoding, width):
    step = width * (1 if encoding == 'nv21' else 2)
    rows = 6 if encoding == 'nv21' else 4
    message = SimpleNamespace(
        encoding=encoding, height=4, width=width, step=step, data=bytes(step * rows)
    )
    with pytest.raises(CodecError, match='expected even'):
        image_from_message(message)


@pytest.mark.parametrize('encoding', ['32FC1', '16SC1', '8UC2', '64FC3', 'unknown', 'nv12', ''])
def test_what_holds_no_image_is_refused_by_its_name(encoding):
    message = SimpleNamespace(encoding=encoding, height=4, width=4, step=64, data=bytes(256))
    with pytest.raises(CodecError, match=f"image encoding '{encoding}' is not known"):
        image_from_message(message)


def png(values, form):
    return SimpleNamespace(format=form, data=cv2.imencode('.png', values)[1].tobytes())


@PATTERNS
@pytest.mark.parametrize('after', ['png compressed ', 'png compressed bgr8', 'png compressed'])
def test_a_mosaic_in_a_png_gets_its_colours(pattern, after):
    message = png(mosaic(pattern), f'bayer_{pattern}8; {after}')
    np.testing.assert_array_equal(image_from_message(message), np.full((8, 12, 3), COLOUR))


@PATTERNS
def test_a_mosaic_of_16_bits_in_a_png_gets_its_colours(pattern):
    values = mosaic(pattern, [257 * value for value in COLOUR], dtype=np.uint16)
    message = png(values, f'bayer_{pattern}16; png compressed ')
    np.testing.assert_array_equal(image_from_message(message), np.full((8, 12, 3), COLOUR))


def test_a_mosaic_in_a_jpeg_gets_its_colours():
    jpeg = cv2.imencode('.jpg', mosaic('rggb', shape=(32, 48)), [cv2.IMWRITE_JPEG_QUALITY, 100])
    message = SimpleNamespace(
        format='bayer_rggb8; jpeg compressed bayer_rggb8', data=jpeg[1].tobytes()
    )
    found = image_from_message(message).astype(int)
    assert np.abs(found - COLOUR).max() < 6
    message.format = 'bayer_rggb8; jpeg compressed mono8'
    grey = image_from_message(message)
    np.testing.assert_array_equal(grey, cv2.imdecode(jpeg[1], cv2.IMREAD_COLOR))


def test_a_png_of_16_bits_is_scaled_as_a_raw_image_is():
    levels = np.random.default_rng(5).integers(0, 65536, (6, 7), np.uint16)
    found = image_from_message(png(levels, 'mono16; png compressed '))
    expected = np.floor(levels / 257 + 0.5).astype(np.uint8)
    np.testing.assert_array_equal(found, np.repeat(expected[..., None], 3, axis=2))


@pytest.mark.parametrize(
    ('form', 'order'),
    [
        ('rgb8; png compressed bgr8', [0, 1, 2]),
        ('bgr8; png compressed bgr8', [0, 1, 2]),
        ('bgra8; png compressed bgra8', [0, 1, 2]),
        ('rgb8; png compressed rgb8', [2, 1, 0]),
        ('png', [0, 1, 2]),
        ('', [0, 1, 2]),
    ],
)
@pytest.mark.parametrize('channels', [3, 4])
def test_the_order_of_colours_is_what_the_format_says(form, order, channels):
    values = np.random.default_rng(6).integers(0, 256, (6, 7, channels), np.uint8)
    np.testing.assert_array_equal(image_from_message(png(values, form)), values[..., order])


def claimed_png(width, height):
    """Return a PNG of 4 x 4 whose header claims another size."""
    data = bytearray(cv2.imencode('.png', np.zeros((4, 4), np.uint8))[1].tobytes())
    data[16:24] = width.to_bytes(4) + height.to_bytes(4)
    data[29:33] = zlib.crc32(data[12:29]).to_bytes(4)
    return bytes(data)


def claimed_jpeg(width, height):
    """Return a JPEG of 16 x 16 whose frame claims another size."""
    data = bytearray(jpeg_from_image(np.zeros((16, 16, 3), np.uint8)).tobytes())
    at = data.index(b'\xff\xc0')
    data[at + 5 : at + 9] = height.to_bytes(2) + width.to_bytes(2)
    return bytes(data)


def padded_jpeg(width, height):
    """Return the same with a marker that nothing follows, and a fill byte before the next one."""
    data = claimed_jpeg(width, height)
    return data[:2] + b'\xff\x01\xff' + data[2:]


@pytest.mark.parametrize('size', [(320, 240), None])
@pytest.mark.parametrize(
    'data',
    [claimed_png(60000, 60000), claimed_jpeg(60000, 60000), padded_jpeg(60000, 60000)],
    ids=['png', 'jpeg', 'padded jpeg'],
)
def test_a_huge_image_is_refused_before_anything_is_allocated(data, size):
    message = SimpleNamespace(format='', data=data)
    tracemalloc.start()
    before_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    with pytest.raises(CodecError, match='image is 60000 x 60000'):
        image_from_message(message, size)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 1 << 20
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024 - before_mb < 50


@pytest.mark.parametrize('suffix', ['.jpg', '.png'])
@pytest.mark.parametrize('colours', [1, 3])
@pytest.mark.parametrize('progressive', [0, 1])
def test_another_size_is_refused_and_the_right_one_is_read(suffix, colours, progressive):
    options = [cv2.IMWRITE_JPEG_PROGRESSIVE, progressive] if suffix == '.jpg' else []
    data = cv2.imencode(suffix, np.full((48, 64, colours), 90, np.uint8), options)[1].tobytes()
    message = SimpleNamespace(format='', data=data)
    assert image_from_message(message, (64, 48)).shape == (48, 64, 3)
    with pytest.raises(CodecError, match='image is 64 x 48, expected 48 x 64'):
        image_from_message(message, (48, 64))


def test_a_raw_image_of_another_size_is_refused():
    message = SimpleNamespace(encoding='mono8', height=4, width=5, step=5, data=bytes(20))
    assert image_from_message(message, (5, 4)).shape == (4, 5, 3)
    with pytest.raises(CodecError, match='image is 5 x 4, expected 4 x 5'):
        image_from_message(message, (4, 5))


@pytest.mark.parametrize(
    ('form', 'data'),
    [
        ('16UC1; compressedDepth png', bytes(12) + claimed_png(4, 4)),
        ('mono8; tiff compressed ', cv2.imencode('.tiff', np.zeros((4, 4), np.uint8))[1]),
    ],
)
def test_other_codecs_are_refused_by_their_name(form, data):
    message = SimpleNamespace(format=form, data=bytes(data))
    with pytest.raises(CodecError, match=f"of a '{form}' image cannot be decompressed"):
        image_from_message(message)


def test_jpeg_gives_the_pixels_that_opencv_gives():
    image = np.random.default_rng(1).integers(0, 256, (48, 64, 3), np.uint8)
    jpeg = jpeg_from_image(cv2.GaussianBlur(image, (5, 5), 0))
    decoded = image_from_message(SimpleNamespace(format='jpeg', data=jpeg.tobytes()))
    np.testing.assert_array_equal(decoded, cv2.imdecode(jpeg, cv2.IMREAD_COLOR))


def test_without_simplejpeg_opencv_decompresses(monkeypatch):
    monkeypatch.setattr('mctrack_ros.codec.images.simplejpeg', None)
    jpeg = jpeg_from_image(np.full((48, 64, 3), 90, np.uint8))
    decoded = image_from_message(SimpleNamespace(format='jpeg', data=jpeg.tobytes()))
    assert decoded.shape == (48, 64, 3)


def test_png_is_read_too():
    image = np.random.default_rng(1).integers(0, 256, (6, 7, 3), np.uint8)
    data = cv2.imencode('.png', image)[1].tobytes()
    decoded = image_from_message(SimpleNamespace(format='png', data=data))
    np.testing.assert_array_equal(decoded, image)


def test_a_cut_off_jpeg_is_refused():
    message = SimpleNamespace(format='jpeg', data=b'\xff\xd8\xff\xe0 cut off')
    with pytest.raises(CodecError, match=r'JPEG image|decompressed'):
        image_from_message(message)


def sample(suffix, *options):
    """Return the bytes of an image of 48 x 64 px."""
    image = cv2.resize(np.random.default_rng(1).integers(0, 256, (6, 8, 3), np.uint8), (64, 48))
    return cv2.imencode(suffix, image, options)[1].tobytes()


@pytest.mark.parametrize('progressive', [0, 1])
@pytest.mark.parametrize('has_simplejpeg', [True, False])
def test_a_jpeg_cut_off_anywhere_is_refused(monkeypatch, capfd, has_simplejpeg, progressive):
    if not has_simplejpeg:
        monkeypatch.setattr('mctrack_ros.codec.images.simplejpeg', None)
    data = sample('.jpg', cv2.IMWRITE_JPEG_PROGRESSIVE, progressive)
    for end in range(0, len(data) - 1, 7):
        with pytest.raises(CodecError):
            image_from_message(SimpleNamespace(format='jpeg', data=data[:end]))
    assert not capfd.readouterr().err


def test_a_damaged_mosaic_in_a_jpeg_is_refused(capfd):
    grey = cv2.imencode('.jpg', np.tile(np.arange(64, dtype=np.uint8), (48, 1)))[1].tobytes()
    form = 'bayer_rggb8; jpeg compressed '
    sound = image_from_message(SimpleNamespace(format=form, data=grey))
    assert sound.shape == (48, 64, 3)
    damaged = grey[:-40] + grey[-20:]
    with pytest.raises(CodecError, match='JPEG image'):
        image_from_message(SimpleNamespace(format=form, data=damaged))
    assert not capfd.readouterr().err


def test_a_png_with_any_byte_changed_or_cut_off_is_refused(capfd):
    data = sample('.png')
    for at in range(8, len(data), 11):
        changed = data[:at] + bytes([data[at] ^ 1]) + data[at + 1 :]
        for kept in (changed, data[:at]):
            with pytest.raises(CodecError):
                image_from_message(SimpleNamespace(format='png', data=kept))
    assert not capfd.readouterr().err


@pytest.mark.parametrize('data', [claimed_png(11000, 11000), claimed_jpeg(11000, 11000)])
def test_more_pixels_than_the_bytes_can_hold_are_refused(data):
    with pytest.raises(CodecError, match='cut off or damaged'):
        image_from_message(SimpleNamespace(format='', data=data))


def test_a_refusal_is_one_short_line_whatever_the_message_is_called():
    name = 'x\n' * 5000
    for message in (
        SimpleNamespace(encoding=name, height=1, width=1, step=1, data=bytes(1)),
        SimpleNamespace(format=name, data=b'none'),
    ):
        with pytest.raises(CodecError) as refusal:
            image_from_message(message)
        assert len(str(refusal.value)) < 500
        assert '\n' not in str(refusal.value)
