from .composition import Presenters, build
from .context import AppContext
from .linked_views import LinkedViews

__all__ = [
    "AppContext",
    "LinkedViews",
    "Presenters",
    "build",
]
