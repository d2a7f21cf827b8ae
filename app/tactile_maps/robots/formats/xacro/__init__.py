"""Robots written with xacro's macros, expanded to plain URDF without running anything of the file's.

Xacro's own program hands the expressions of a file to Python's ``eval``, behind a guard that a lambda gets round, and
opens any file that is named. Here ``expressions`` works out a fixed set of operations and functions, and ``expand``
opens only what the model may open: see ``tactile_maps.robots.files.model_files``.
"""

from tactile_maps.robots.formats.xacro.expand import has_xacro, process_xacro

__all__ = ["has_xacro", "process_xacro"]
