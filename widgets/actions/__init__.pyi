from .menus import build_menus
from .registry import ActionRegistry, ActionSpec

__all__ = [
    "ActionRegistry",
    "ActionSpec",
    "build_menus",
]
