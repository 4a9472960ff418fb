"""How large people are where in the image, and how well their feet are measured."""
