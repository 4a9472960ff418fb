"""Joint occupancy: which set of people explains the foreground masks of all cameras."""
