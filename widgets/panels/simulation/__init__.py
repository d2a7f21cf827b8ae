"""Panels of what is simulated and what it costs: effects, accuracy against time, timing."""
