"""Shared by the commands: output, progress, scene options and worker processes."""
