"""Experiment III of the event-tracking paper: events and identities on the pitch."""
