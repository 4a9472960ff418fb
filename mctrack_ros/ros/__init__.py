"""The graph's nodes."""
