"""What an image looks like without moving objects, and which pixels differ from it."""
