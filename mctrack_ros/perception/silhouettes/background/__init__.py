"""The background of the silhouettes paper, and objects that rest in it."""
