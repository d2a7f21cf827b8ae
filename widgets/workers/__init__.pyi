from .accuracy_worker import AccuracyWorker
from .comparison_worker import ComparisonWorker
from .cost_worker import CostWorker
from .map_quality_worker import MapQualityWorker
from .scene_worker import SceneWorker

__all__ = [
    "AccuracyWorker",
    "ComparisonWorker",
    "CostWorker",
    "MapQualityWorker",
    "SceneWorker",
]
