"""What cameras and their masks cost."""
