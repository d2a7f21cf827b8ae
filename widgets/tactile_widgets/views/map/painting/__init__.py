"""Paint the parts of a map view."""
