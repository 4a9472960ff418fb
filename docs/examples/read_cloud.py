"""Read any of the graph's clouds with NumPy alone: `fields(message)['track_id']`."""

import numpy as np

TYPES = {1: 'i1', 2: 'u1', 3: '<i2', 4: '<u2', 5: '<i4', 6: '<u4', 7: '<f4', 8: '<f8'}


def fields(message):
    """Return an array by field name; works on messages of rclpy and of rosbags."""
    dtype = np.dtype(
        {
            'names': [field.name for field in message.fields],
            'formats': [(TYPES[field.datatype], (field.count,)) for field in message.fields],
            'offsets': [field.offset for field in message.fields],
            'itemsize': message.point_step,
        }
    )
    rows = np.frombuffer(message.data, dtype)
    return {
        name: rows[name][:, 0] if dtype[name].shape == (1,) else rows[name] for name in dtype.names
    }
