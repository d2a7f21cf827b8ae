from .control_settings_editor import ControlSettingsEditor
from .interest_tool import InterestTool
from .path_tool import PathTool
from .pin_tool import PinTool
from .registry import TOOLS, Tools, ToolSpec
from .seam_tool import SeamTool
from .target_tool import TargetTool

__all__ = [
    "TOOLS",
    "ControlSettingsEditor",
    "InterestTool",
    "PathTool",
    "PinTool",
    "SeamTool",
    "TargetTool",
    "ToolSpec",
    "Tools",
]
