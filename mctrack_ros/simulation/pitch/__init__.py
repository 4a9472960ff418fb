"""The football pitch and those who play on it."""
