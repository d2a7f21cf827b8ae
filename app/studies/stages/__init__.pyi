from .registry import STAGES, edits_map

__all__ = [
    "STAGES",
    "edits_map",
]
