"""The detections of one tick: which can be used, and as packed arrays."""
