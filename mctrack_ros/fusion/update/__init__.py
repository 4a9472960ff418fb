"""What tracks learn from their detections."""
