"""Streams over HTTP and web sockets: read-only, guarded, bounded."""
