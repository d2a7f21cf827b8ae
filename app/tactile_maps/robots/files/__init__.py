"""Files of a model: their search, safe reading, and limits of size."""
