"""What the force estimators are called, in scenes, recordings and commands."""

from __future__ import annotations

from typing import Literal, TypeAlias, get_args

EstimatorName: TypeAlias = Literal["area-sum", "local-nnls", "tikhonov", "lumped"]
ESTIMATORS: tuple[EstimatorName, ...] = get_args(EstimatorName)
