"""Presenters for files: opening and saving, recordings, studies, exports, figures and films."""
