"""Staged scenes of a few people: one question each."""
