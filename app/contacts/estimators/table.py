"""The force estimators by name."""

from __future__ import annotations

from typing import Literal, get_args

from app.contacts.estimators.area_sum import AreaSum
from app.contacts.estimators.estimate import ForceEstimator
from app.contacts.estimators.local_nnls import LocalNnls
from app.contacts.estimators.lumped import Lumped
from app.contacts.estimators.tikhonov import Tikhonov
from app.skin.skin import Skin

EstimatorName = Literal["area-sum", "local-nnls", "tikhonov", "lumped"]
ESTIMATORS: tuple[EstimatorName, ...] = get_args(EstimatorName)


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
            return LocalNnls(skin, depth=depth)
        case "tikhonov":
            return Tikhonov(skin, depth=depth)
        case "lumped":
            return Lumped(skin)
