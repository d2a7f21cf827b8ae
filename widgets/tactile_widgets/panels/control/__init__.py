"""Panels of what the arm does about a contact: the controller and its settings, the behaviours."""
