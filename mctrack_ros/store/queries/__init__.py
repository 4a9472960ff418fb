"""Questions to the trajectory database, and answers as text and files."""
