"""Effects of a sensor between true pressure and reading."""
