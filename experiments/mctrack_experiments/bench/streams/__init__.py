"""How large streams are, and what hostile readers cost tracking."""
