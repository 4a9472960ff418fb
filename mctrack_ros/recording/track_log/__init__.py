"""What a bag says of itself: the hash of its tracks, checksums of its messages, who made it."""
