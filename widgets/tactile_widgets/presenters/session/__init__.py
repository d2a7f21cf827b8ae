"""Presenters for the session: scenes and ticks, recordings, touches, effects, accuracy and time."""
