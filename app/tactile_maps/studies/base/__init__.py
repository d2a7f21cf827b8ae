"""Foundations of studies: ``rows`` (tables and statistics), ``figures``, and ``hypotheses`` about rows."""
