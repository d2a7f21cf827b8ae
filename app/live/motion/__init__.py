"""What a controller wants of a real robot: worked out from a measured skin, shown, and sent where a hand says so."""
