"""How fast the parts are, beside a peer in the same run."""
