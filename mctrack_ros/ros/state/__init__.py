"""What lasts longer than the process of a node."""
