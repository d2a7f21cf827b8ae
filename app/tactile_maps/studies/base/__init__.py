"""Rows of a study, their statistics and figures."""
