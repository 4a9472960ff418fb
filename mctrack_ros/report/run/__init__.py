"""What a run was: a page and a PDF for people."""
