"""Panels of the model: skin, effects, accuracy and timing."""
