"""A session on measured readings, and its connection to a source."""
