from .control.control_settings_editor import ControlSettingsEditor
from .control.path_tool import PathTool
from .control.target_tool import TargetTool
from .map_editing.interest_tool import InterestTool
from .map_editing.pin_tool import PinTool
from .map_editing.seam_tool import SeamTool
from .registry import TOOLS, Tools, ToolSpec

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
