"""What other ROS packages know: frames, camera info, their own messages."""
