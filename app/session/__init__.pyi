from .frame import Failure, Frame
from .inputs import ControlChanged, SessionInput
from .prepare import PreparedScene, open_scene
from .runtime_settings import RuntimeSettings
from .session import Session

__all__ = [
    "ControlChanged",
    "Failure",
    "Frame",
    "PreparedScene",
    "RuntimeSettings",
    "Session",
    "SessionInput",
    "open_scene",
]
