"""Re-identification by appearance, after an encounter or a loss."""
