"""Faults in a live graph: what names them, what goes on, and what is lost."""
