"""What a person gets of a study: ``figures`` are drawn, ``report`` writes CSV, JSON, Parquet and one HTML page."""
