"""Reference update (silhouettes paper, section 5): what rests, and holes, become background."""
