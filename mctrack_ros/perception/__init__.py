"""One camera: picture and feedback in, detections out."""
