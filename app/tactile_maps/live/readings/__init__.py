"""Readings as they arrive: their wire format, time and age."""
