from .frame import Failure, Frame
from .inputs import SessionInput
from .prepare import PreparedScene, open_scene
from .runtime_settings import RuntimeSettings
from .session import Session

__all__ = [
    "Failure",
    "Frame",
    "PreparedScene",
    "RuntimeSettings",
    "Session",
    "SessionInput",
    "open_scene",
]
