"""What goes on in the car park."""
