"""Text tables and messages of other tools: boxes, positions."""
