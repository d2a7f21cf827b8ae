"""Panels of the readings of the skin: contacts, contact events, and those of a connected skin."""
