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
from .progress import Progress, no_progress
from .timing import Stopwatch, Timings

__all__ = [
    "BoolArray",
    "DisplayError",
    "Finding",
    "FloatArray",
    "IntArray",
    "MapError",
    "MeshError",
    "Progress",
    "RecordingError",
    "RobotError",
    "SceneError",
    "SimulationError",
    "SkinError",
    "Stopwatch",
    "TactileMapsError",
    "Timings",
    "UsageError",
    "no_progress",
    "readonly",
]
