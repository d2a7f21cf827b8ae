from .behaviours import Behaviour, BehaviourTrigger
from .command import (
    ControllerName,
    ControlSettings,
    JointCommand,
    RegraspState,
    TaskReport,
)
from .controller_manager import ControllerManager
from .controller_registry import (
    CONTROLLERS,
    ControllerEntry,
    build_by_scheme,
    build_controller,
    check_settings,
    effective_settings,
    settings_from,
)
from .controllers import Controller
from .force_loop.loop_stability import SensorTiming, StepResponse, step_response
from .limit_texts import limit_name, limit_text
from .limits import Limit, LimitKind, RegraspFailure

__all__ = [
    "CONTROLLERS",
    "Behaviour",
    "BehaviourTrigger",
    "ControlSettings",
    "Controller",
    "ControllerEntry",
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
    "build_by_scheme",
    "build_controller",
    "check_settings",
    "effective_settings",
    "limit_name",
    "limit_text",
    "settings_from",
    "step_response",
]
