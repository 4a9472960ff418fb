"""The coverage page: what the cameras of a site see."""
