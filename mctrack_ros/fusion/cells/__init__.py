"""Fusion of cells: the tracks of several fusion nodes in, those of the whole site out."""
