"""Panels of the model: skin, effects, accuracy and timing, findings and messages."""
