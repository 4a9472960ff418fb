"""From the foreground mask to silhouettes."""
