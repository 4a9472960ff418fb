"""A site of a hundred cameras in cells: who keeps an id from cell to cell, and what it costs."""
