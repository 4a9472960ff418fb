"""People as they look, and what a camera makes of a scene."""
