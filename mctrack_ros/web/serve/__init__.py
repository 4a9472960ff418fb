"""Pages served to this machine, or to whoever knows the token."""
