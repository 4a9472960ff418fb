"""Tracks begin, are confirmed, hidden, merged and deleted."""
