"""Feedback of the fusion node: checked, kept until due, matched with local tracks."""
