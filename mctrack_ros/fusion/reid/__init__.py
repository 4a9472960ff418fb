"""Who is who after an encounter or a loss: re-identification by appearance."""
