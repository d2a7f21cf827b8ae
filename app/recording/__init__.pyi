from .player import RecordingPlayer
from .recorder import Recorder, save_failure_report

__all__ = [
    "Recorder",
    "RecordingPlayer",
    "save_failure_report",
]
