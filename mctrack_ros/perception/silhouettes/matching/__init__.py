"""Steps 1 to 7 of the silhouettes paper: which silhouette belongs to which object."""
