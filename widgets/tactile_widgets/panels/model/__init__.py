"""Panels of the simulation: effects, accuracy and timing."""
