"""What perception and fusion share: filters and association."""
