from .colours import PressureScale, Theme
from .settings import OverlayOptions, Settings
from .tool_kinds import ToolKind

__all__ = [
    "OverlayOptions",
    "PressureScale",
    "Settings",
    "Theme",
    "ToolKind",
]
