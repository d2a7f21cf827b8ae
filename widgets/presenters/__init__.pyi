from .linked_views import LinkedViews

__all__ = [
    "LinkedViews",
]
