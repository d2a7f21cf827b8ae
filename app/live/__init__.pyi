from .channels.calibration import Calibration, ValueMode, load_calibration, save_calibration
from .connection import Connection
from .measured_session import MeasuredSession
from .prepare import prepare_measured
from .readings import Reading, Unit
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
