from .registry import STAGES, edits_map, reflatten_for

__all__ = [
    "STAGES",
    "edits_map",
    "reflatten_for",
]
