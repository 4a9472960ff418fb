"""Groups and events of the event-tracking paper, as one camera sees them."""
