"""Connected foreground: noise removed, fragments joined."""
