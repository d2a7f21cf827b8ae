from .map_editor import MapEditor
from .stage_settings import reflatten_for, subject_of
from .taxel_selection import TaxelSelection

__all__ = [
    "MapEditor",
    "TaxelSelection",
    "reflatten_for",
    "subject_of",
]
