"""The session that runs: its scene and frames, its touches, its effects, what it costs."""
