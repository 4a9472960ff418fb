"""All cameras: detections in; tracks, feedback and events out."""
