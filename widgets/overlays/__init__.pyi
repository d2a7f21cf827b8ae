from .body_overlays import SkinTexture, ToolMarks
from .task_overlay import TaskOverlay
from .task_overlay_builder import TaskOverlayBuilder

__all__ = [
    "SkinTexture",
    "TaskOverlay",
    "TaskOverlayBuilder",
    "ToolMarks",
]
