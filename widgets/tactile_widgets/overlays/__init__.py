"""Faults of taxels, as values that both views draw in their own way."""
