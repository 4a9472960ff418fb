"""Which blobs are one person, and where people stand in blobs that several share."""
