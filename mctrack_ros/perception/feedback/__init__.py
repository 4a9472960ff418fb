"""What the fusion node tells a camera: checked, kept until due, matched with local tracks."""
