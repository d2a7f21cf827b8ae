"""Overlays that are painted on both views."""
