"""Sets of nodes as processes: started, watched, started again, stopped."""
