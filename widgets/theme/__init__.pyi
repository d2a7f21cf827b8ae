from .application_theme import apply_theme

__all__ = [
    "apply_theme",
]
