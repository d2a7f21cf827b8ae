"""Panels of the model: effects, accuracy and timing."""
