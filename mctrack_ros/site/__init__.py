"""A site: its cameras, names, description, origin and coverage."""
