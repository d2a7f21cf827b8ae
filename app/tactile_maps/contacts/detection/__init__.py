"""Find contacts in the readings of a skin, with their places, forces and uncertainties, and track them."""
