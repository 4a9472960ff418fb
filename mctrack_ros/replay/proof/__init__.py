"""A replay gives what was recorded: compared, and gone on with from the middle."""
