"""How a bag is played: its pace, and what sets it."""
