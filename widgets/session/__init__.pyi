from .backends import BACKGROUND, INLINE, Backends
from .live_session import LiveSession

__all__ = [
    "BACKGROUND",
    "INLINE",
    "Backends",
    "LiveSession",
]
