from .centre_of_pressure import SensorUncertainty
from .detection import ContactDetector
from .events import ContactEvent, EventDetector
from .pipeline import ContactPipeline, ReadingSettings, read_contacts
from .regions import ContactRegion
from .self_touch import SelfTouchMatcher
from .tracking import RegionTracker

__all__ = [
    "ContactDetector",
    "ContactEvent",
    "ContactPipeline",
    "ContactRegion",
    "EventDetector",
    "ReadingSettings",
    "RegionTracker",
    "SelfTouchMatcher",
    "SensorUncertainty",
    "read_contacts",
]
