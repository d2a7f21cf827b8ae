"""Where taxels go on a surface: what a person asks for, the patterns, even sampling, the part that is usable."""
