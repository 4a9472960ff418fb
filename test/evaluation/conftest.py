"""The match with known faults."""

from recorded_match import match  # noqa: F401
