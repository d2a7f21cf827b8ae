from .playhead import Playhead
from .timeline import Timeline

__all__ = [
    "Playhead",
    "Timeline",
]
