import gzip
import zlib

from mctrack_ros.streams.serve.packing import KEY_FRAMES, Block, GzipWriter, SharedPacker

TEXTS = [f'<frame n="{n}">{"track " * 50}{n * n}</frame>\n'.encode() for n in range(130)]


def read(parts):
    """Return what a client has read after each part."""
    reader = zlib.decompressobj(16 + zlib.MAX_WBITS)
    return [reader.decompress(part) for part in parts], reader


def test_every_frame_can_be_read_as_soon_as_it_is_sent():
    packer, writer = SharedPacker(), GzipWriter()
    parts = [writer.begin(b'<head>')] + [writer.write(packer.pack(text)) for text in TEXTS]
    found, reader = read([*parts, writer.end(b'</head>')])
    assert found == [b'<head>', *TEXTS, b'</head>']
    assert reader.eof


def test_who_joins_later_reads_the_same_frames():
    packer = SharedPacker()
    blocks = [packer.pack(text) for text in TEXTS]
    for start in (1, KEY_FRAMES - 1, KEY_FRAMES, 2 * KEY_FRAMES + 7):
        writer = GzipWriter()
        parts = [writer.begin(b''), writer.write(Block(b'past'))]
        parts += [writer.write(block) for block in blocks[start:]] + [writer.end(b'')]
        assert gzip.decompress(b''.join(parts)) == b'past' + b''.join(TEXTS[start:])


def test_what_all_are_sent_is_packed_once():
    packer = SharedPacker()
    blocks = [packer.pack(text) for text in TEXTS]
    one, other = GzipWriter(), GzipWriter()
    for writer in (one, other):
        writer.begin(b'')
        writer.write(blocks[0])
    assert one.write(blocks[1]) is other.write(blocks[1]) is blocks[1].packed


def test_after_a_pause_a_key_comes_first():
    packer = SharedPacker()
    assert [packer.pack(text).is_key for text in TEXTS[:3]] == [True, False, False]
    packer.pause()
    assert packer.pack(TEXTS[3]).is_key
