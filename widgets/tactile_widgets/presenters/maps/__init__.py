"""Presenters of the map document and its files."""
