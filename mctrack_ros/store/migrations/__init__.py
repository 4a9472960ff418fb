"""Versions of the trajectory database's tables, by Alembic."""
