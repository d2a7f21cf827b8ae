from .composition import Presenters, build

__all__ = [
    "Presenters",
    "build",
]
