from .behaviours import Behaviour, BehaviourTrigger
from .command import (
    ControlChanged,
    ControllerName,
    ControlSettings,
    JointCommand,
    TaskReport,
    check_settings,
    settings_from,
)
from .controller_manager import ControllerManager
from .controllers import Controller, build_controller, effective_settings
from .loop_stability import SensorTiming, StepResponse, step_response

__all__ = [
    "Behaviour",
    "BehaviourTrigger",
    "ControlChanged",
    "ControlSettings",
    "Controller",
    "ControllerManager",
    "ControllerName",
    "JointCommand",
    "SensorTiming",
    "StepResponse",
    "TaskReport",
    "build_controller",
    "check_settings",
    "effective_settings",
    "settings_from",
    "step_response",
]
