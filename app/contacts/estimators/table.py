"""The force estimators by name."""

from __future__ import annotations

from app.contacts.estimators.area_sum import AreaSum
from app.contacts.estimators.estimate import ForceEstimator
from app.contacts.estimators.local_nnls import nonnegative
from app.contacts.estimators.lumped import Lumped
from app.contacts.estimators.names import EstimatorName
from app.contacts.estimators.tikhonov import smoothed
from app.contacts.estimators.unblurred import Unblurred
from app.skin.skin import Skin


def make_estimator(name: EstimatorName, skin: Skin, *, depth: float) -> ForceEstimator:
    """The estimator of that name for a skin.

    Args:
        name: Which.
        skin: The skin.
        depth: Of its taxels below the surface [m]; only those that undo the blur use it.

    Raises:
        MapError: The depth is no such number.
    """
    match name:
        case "area-sum":
            return AreaSum(skin)
        case "local-nnls":
            return Unblurred(skin, nonnegative, depth=depth)
        case "tikhonov":
            return Unblurred(skin, smoothed, depth=depth)
        case "lumped":
            return Lumped(skin)
