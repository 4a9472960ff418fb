"""The default tracker: all cameras' detections associated jointly, one step a tick."""
