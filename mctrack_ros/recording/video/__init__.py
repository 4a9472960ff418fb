"""Video files: images and the times that the files state."""
