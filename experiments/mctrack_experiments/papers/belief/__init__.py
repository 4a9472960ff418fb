"""The belief-propagation paper: moving cameras, scripted occlusions and their protocol."""
