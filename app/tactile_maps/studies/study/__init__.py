"""A study, and how its results are reported."""
