"""The window that compares controllers."""
