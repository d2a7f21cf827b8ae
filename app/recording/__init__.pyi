from .player import RecordingPlayer, open_recording
from .recorder import Recorder, record, save_failure_report

__all__ = [
    "Recorder",
    "RecordingPlayer",
    "open_recording",
    "record",
    "save_failure_report",
]
