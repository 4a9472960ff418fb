"""A camera as ROS tells it: messages of rosbags or rclpy, by their types' names."""

import numpy as np

from lens_cameras import SIZE, camera
from mctrack_ros.ground import stored_camera

POLE = (1.0, 2.0, 6.0)
"""Where the camera stands in its house, m; the house is turned by a quarter on the map."""
HOUSE, HOUSE_TURN = (10.0, 20.0, 0.0), (0.0, 0.0, np.sqrt(0.5), np.sqrt(0.5))
DOWN_TURN = (-0.9, 0.0, 0.0, np.sqrt(1 - 0.81))


def house_place(place):
    """Return where a place in the house lies on the map, by hand: a quarter turn, a shift."""
    x, y, z = place
    return np.array([10.0 - y, 20.0 + x, z])


def stamped(kinds, parent, child, shift, turn):
    """Return a `TransformStamped`."""
    transform = kinds('geometry_msgs/msg/Transform')(
        translation=kinds('geometry_msgs/msg/Vector3')(**numbers('xyz', shift)),
        rotation=kinds('geometry_msgs/msg/Quaternion')(**numbers('xyzw', turn)),
    )
    return kinds('geometry_msgs/msg/TransformStamped')(
        header=header(kinds, parent), child_frame_id=child, transform=transform
    )


def transforms(kinds, *each):
    """Return a `TFMessage` of (parent, child, shift, turn)."""
    return kinds('tf2_msgs/msg/TFMessage')(transforms=[stamped(kinds, *one) for one in each])


def header(kinds, frame):
    return kinds('std_msgs/msg/Header')(
        stamp=kinds('builtin_interfaces/msg/Time')(sec=0, nanosec=0), frame_id=frame
    )


def camera_info(kinds, frame='north_optical_frame', binning=0, region=(0, 0, 0, 0)):
    """Return the `CameraInfo` of a bent lens, and its `StoredCamera`."""
    stored = stored_camera(camera(distortion=(-0.2, 0.05, 1e-3, -5e-4, 0.01)))
    across, down, x, y = stored.intrinsics.tolist()
    left, top, width, height = region
    info = kinds('sensor_msgs/msg/CameraInfo')(
        header=header(kinds, frame),
        width=SIZE[0],
        height=SIZE[1],
        distortion_model='plumb_bob',
        d=np.array(stored.distortion),
        k=np.array([across, 0, x, 0, down, y, 0, 0, 1.0]),
        r=np.eye(3).ravel(),
        p=np.zeros(12),
        binning_x=binning,
        binning_y=binning,
        roi=kinds('sensor_msgs/msg/RegionOfInterest')(
            x_offset=left, y_offset=top, width=width, height=height, do_rectify=False
        ),
    )
    return info, stored


def numbers(names, values):
    return dict(zip(names, (float(value) for value in values)))
