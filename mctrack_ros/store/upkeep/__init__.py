"""What keeps a database whole and small: checks, retention, deletion."""
