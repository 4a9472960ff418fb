"""The commands, by what they need."""
