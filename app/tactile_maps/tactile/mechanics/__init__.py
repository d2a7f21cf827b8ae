"""Mechanics of an elastic skin: loads, stress and receptive fields."""
