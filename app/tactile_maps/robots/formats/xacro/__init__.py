"""Expansion of xacro macros to plain URDF without executing code of the file.

The program xacro passes the expressions of a file to Python's ``eval``, with a guard that a lambda circumvents, and
opens any named file. Here ``expressions`` evaluates a fixed set of operations and functions, and ``expand`` opens only
files that the model may open, see ``tactile_maps.robots.files.model_files``.
"""

from tactile_maps.robots.formats.xacro.expand import has_xacro, process_xacro

__all__ = ["has_xacro", "process_xacro"]
