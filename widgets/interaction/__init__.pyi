from .poke_gesture import PokeGesture
from .select_gesture import TaxelSelector
from .view_tool import PointerHit, ViewTool

__all__ = [
    "PointerHit",
    "PokeGesture",
    "TaxelSelector",
    "ViewTool",
]
