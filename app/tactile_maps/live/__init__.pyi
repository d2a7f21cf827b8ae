from .channels.calibration import Calibration, ValueMode, load_calibration, save_calibration
from .prepare import prepare_measured
from .readings.readings import Reading, Unit
from .session.connection import Connection
from .session.measured_session import MeasuredSession
from .simulated_skin import SimulatedSkin, SkinDifference
from .sources.open import open_source

__all__ = [
    "Calibration",
    "Connection",
    "MeasuredSession",
    "Reading",
    "SimulatedSkin",
    "SkinDifference",
    "Unit",
    "ValueMode",
    "load_calibration",
    "open_source",
    "prepare_measured",
    "save_calibration",
]
