from .menus import build_menus
from .registry import ActionSpec, make_actions

__all__ = [
    "ActionSpec",
    "build_menus",
    "make_actions",
]
