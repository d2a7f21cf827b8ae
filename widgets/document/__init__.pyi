from .map_editor import MapEditor
from .taxel_selection import TaxelSelection

__all__ = [
    "MapEditor",
    "TaxelSelection",
]
