"""Messages of a running graph into a database that may be away."""
