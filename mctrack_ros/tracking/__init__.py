"""What both the cameras and the fusion use: filters, appearance, association."""
