from .calibration.calibration import Calibration, ValueMode, load_calibration, save_calibration
from .calibration.calibration_log import CalibrationLog, read_calibration_log
from .calibration.force_calibration import ForceCalibration, fit_force
from .prepare import prepare_measured
from .readings.readings import Reading, Unit
from .session.connection import Connection
from .session.measured_session import MeasuredSession
from .simulated_skin import SimulatedSkin, SkinDifference
from .sources.open import open_source

__all__ = [
    "Calibration",
    "CalibrationLog",
    "Connection",
    "ForceCalibration",
    "MeasuredSession",
    "Reading",
    "SimulatedSkin",
    "SkinDifference",
    "Unit",
    "ValueMode",
    "fit_force",
    "load_calibration",
    "open_source",
    "prepare_measured",
    "read_calibration_log",
    "save_calibration",
]
