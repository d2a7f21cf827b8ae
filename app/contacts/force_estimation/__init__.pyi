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
from .wrench_consistency import WrenchMismatch, wrench_mismatch

__all__ = [
    "ESTIMATORS",
    "ContactReading",
    "EstimateRefusal",
    "EstimatorName",
    "ForceEstimate",
    "ForceEstimator",
    "RegionForceEstimator",
    "Wrench",
    "WrenchMismatch",
    "build_estimator",
    "wrench_mismatch",
    "wrench_of_torques",
]
