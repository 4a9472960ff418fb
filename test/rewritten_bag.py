"""Bags of which something was changed, with what was attached to them."""

from mctrack_ros.recording import BagReader, BagWriter, attachments
from mctrack_ros.recording.bags.definitions import TYPES
from mctrack_ros.recording.bags.mcap_file import McapFile

CLOUD = 'sensor_msgs/msg/PointCloud2'


def rewritten(bag, path, change):
    """
    Copy a bag into a file.

    `change` gets topic, number of the message there, and its bytes; None in return drops it.

    """
    copy, number = McapFile(path, is_packed=False), {}
    with BagReader(bag) as reader:
        for topic, kind, data, time_ns in reader.serialized():
            number[topic] = number.get(topic, -1) + 1
            if topic not in copy.counts:
                copy.add(topic, kind, reader.definition(topic), reader.offered(topic))
            changed = change(topic, number[topic], data)
            if changed is not None:
                copy.write(topic, time_ns, changed)
    for name, data in attachments(bag).items():
        copy.attach(name, '', data, 0)
    copy.close('')
    return path


def flipped(data, name, row, bit):
    """Return a serialised cloud with one bit of a field of one row changed."""
    message = TYPES.deserialize_cdr(data, CLOUD)
    (field,) = (each for each in message.fields if each.name == name)
    message.data = message.data.copy()
    message.data[row * message.point_step + field.offset + bit // 8] ^= 1 << bit % 8
    return bytes(TYPES.serialize_cdr(message, CLOUD))


def part_of(bag, out, begin_s, end_s):
    """Copy what was logged in some seconds of a bag."""
    with BagReader(bag) as reader, BagWriter(out) as writer:
        items = list(reader.serialized())
        for item in items:
            if begin_s <= (item[-1] - items[0][-1]) * 1e-9 < end_s:
                writer.write_copy(reader, *item)
    return out
