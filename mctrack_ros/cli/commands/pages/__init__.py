"""Commands that serve pages in a browser."""
