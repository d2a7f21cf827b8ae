from .control_settings_editor import ControlSettingsEditor
from .interest_tool import InterestTool
from .path_tool import PathTool
from .pin_tool import PinTool
from .seam_tool import SeamTool
from .target_tool import TargetTool

__all__ = [
    "ControlSettingsEditor",
    "InterestTool",
    "PathTool",
    "PinTool",
    "SeamTool",
    "TargetTool",
]
