import numpy as np

from mctrack_ros.interfaces import Detections, Tracks, TrackStatus
from mctrack_ros.web.live.frames import BOX, HEAD, IMAGE, NOW, ROW, image_message, tracks_message


def test_a_frame_holds_who_is_somewhere_and_not_deleted():
    tracks = Tracks.build(
        5_500_000_000,
        position=[(1, 2, 0), (3, 4, 0), (np.nan, np.nan, 0)],
        covariance=np.arange(48).reshape(3, 4, 4),
        track_id=[7, 8, 9],
        cameras=[5, 0, 0],
        status=[TrackStatus.COASTING, TrackStatus.DELETED, TrackStatus.CONFIRMED],
    )
    message = tracks_message(tracks)
    kind, _, _, count, time_s, _ = HEAD.unpack_from(message)
    assert (kind, count, time_s) == (NOW, 1, 5.5)
    (row,) = np.frombuffer(message, ROW, offset=HEAD.size)
    assert (row['id'], row['cameras'], row['status']) == (7, 5, TrackStatus.COASTING)
    assert row['position'].tolist() == [1, 2]
    assert row['covariance'].tolist() == [0, 1, 5]


def test_an_image_comes_with_the_boxes_of_what_is_there():
    found = Detections.build(
        0,
        position=np.zeros((3, 3)),
        box=[(1, 2, 3, 4), (5, 6, 7, 8), (0, 0, 0, 0)],
        score=[1.0, 0.0, 1.0],
        track_id=[3, 4, 5],
    )
    message = image_message(2, 1_000_000_000, b'jpeg', found)
    assert HEAD.unpack_from(message)[:4] == (IMAGE, 2, 0, 1)
    (box,) = np.frombuffer(message, BOX, 1, HEAD.size)
    assert (box['id'], box['box'].tolist()) == (3, [1, 2, 3, 4])
    assert message.endswith(b'jpeg')
    assert HEAD.size % 4 == ROW.itemsize % 4 == BOX.itemsize % 4 == 0
