"""Figures and films: their dialogs and files."""
