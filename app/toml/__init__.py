"""TOML that people write: every mistake named with its line, its key and what would be right.

``reader`` gives typed values, ``line_numbers`` finds where a key stands (TOML's own reader forgets), ``units`` and
``nearest`` guess what was meant, ``lines`` writes values back.
"""
