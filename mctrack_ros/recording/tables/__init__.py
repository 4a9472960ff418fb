"""Text tables and messages of other tools: tracks, boxes, positions."""
