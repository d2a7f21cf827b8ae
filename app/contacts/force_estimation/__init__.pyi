from .estimate import (
    ESTIMATORS,
    ContactReading,
    EstimateRefusal,
    EstimatorName,
    ForceEstimate,
    ForceEstimator,
    Wrench,
    wrench_of_torques,
)
from .estimation import RegionForceEstimator, build_estimator

__all__ = [
    "ESTIMATORS",
    "ContactReading",
    "EstimateRefusal",
    "EstimatorName",
    "ForceEstimate",
    "ForceEstimator",
    "RegionForceEstimator",
    "Wrench",
    "build_estimator",
    "wrench_of_torques",
]
