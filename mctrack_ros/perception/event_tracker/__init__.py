"""The event-tracking paper's camera tracker, which is the default."""
