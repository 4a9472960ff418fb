"""Which detection belongs to which track: gate, likelihood, assignment."""
