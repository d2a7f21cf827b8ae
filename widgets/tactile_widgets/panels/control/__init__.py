"""Panels of the controller and its settings, of behaviours, and of the posture."""
