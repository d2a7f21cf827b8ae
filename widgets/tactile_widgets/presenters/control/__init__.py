"""Presenters of control: controllers, tasks and settings, from menu and panel, and comparison of controllers."""
