"""Foreground against pixel truth, beside peers."""
