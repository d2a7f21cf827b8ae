"""Files of a model: where they lie, how they are read without harm, how large a model may be."""
