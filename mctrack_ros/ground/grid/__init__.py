"""The transformation grid of the event-tracking paper (section 4.4)."""
