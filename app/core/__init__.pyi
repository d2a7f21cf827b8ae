from .arrays import BoolArray, FloatArray, IntArray, readonly
from .errors import (
    DisplayError,
    Finding,
    MapError,
    MeshError,
    RecordingError,
    RobotError,
    SceneError,
    SimulationError,
    SkinError,
    TactileMapsError,
    UsageError,
)
from .timing import Stopwatch, Timings

__all__ = [
    "BoolArray",
    "DisplayError",
    "Finding",
    "FloatArray",
    "IntArray",
    "MapError",
    "MeshError",
    "RecordingError",
    "RobotError",
    "SceneError",
    "SimulationError",
    "SkinError",
    "Stopwatch",
    "TactileMapsError",
    "Timings",
    "UsageError",
    "readonly",
]
