"""A camera's own tracks: prediction, association, update, initiation, deletion, classes."""
