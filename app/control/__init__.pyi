from .behaviours import Behaviour, BehaviourTrigger
from .command import (
    ControllerName,
    ControlSettings,
    JointCommand,
    RegraspState,
    TaskReport,
    check_settings,
    settings_from,
)
from .controller_manager import ControllerManager
from .controllers import Controller, build_controller, effective_settings
from .limit_texts import limit_name, limit_text
from .limits import Limit, LimitKind, RegraspFailure
from .loop_stability import SensorTiming, StepResponse, step_response

__all__ = [
    "Behaviour",
    "BehaviourTrigger",
    "ControlSettings",
    "Controller",
    "ControllerManager",
    "ControllerName",
    "JointCommand",
    "Limit",
    "LimitKind",
    "RegraspFailure",
    "RegraspState",
    "SensorTiming",
    "StepResponse",
    "TaskReport",
    "build_controller",
    "check_settings",
    "effective_settings",
    "limit_name",
    "limit_text",
    "settings_from",
    "step_response",
]
