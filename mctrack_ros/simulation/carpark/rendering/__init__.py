"""What the camera over the car park sees."""
