"""The trajectory database."""
