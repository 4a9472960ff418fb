"""Messages of a graph, serialised as they travel."""

import json

from mctrack_ros.codec import cloud_from_rows
from mctrack_ros.recording import ROSBAGS_CLASSES
from mctrack_ros.recording.bags.definitions import TYPES


def serialised(rows, frame_id='map'):
    message = cloud_from_rows(rows, ROSBAGS_CLASSES, frame_id)
    return bytes(TYPES.serialize_cdr(message, message.__msgtype__))


def site_message(run, cameras=('north', 'south')):
    kind = 'std_msgs/msg/String'
    text = json.dumps({'run': run, 'cameras': cameras})
    return bytes(TYPES.serialize_cdr(TYPES.types[kind](data=text), kind))
