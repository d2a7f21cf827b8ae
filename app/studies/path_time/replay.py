"""The run behind a row of path time, to be simulated anew."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from app.core.errors import UsageError
from app.session.inputs import ControlChanged
from app.studies.path_time.body_path import path_length
from app.studies.path_time.conditions import setup_of
from app.studies.path_time.factors import Factor
from app.studies.path_time.path_time import QUICK_SIZE, conditions_of, settings_of
from app.studies.path_time.speed_search import SLOWEST
from app.studies.rows import Row, number_or
from app.studies.study import CaseReplay
from app.studies.testbeds.path_following import SETTLING


def replay_row(factors: Sequence[Factor], row: Row) -> CaseReplay:
    """The run behind a row, at the speed that was found; where none was well enough, at the slowest that was tried.

    Raises:
        UsageError: The row is of no case of these factors, or its controller believes another map than the true one:
            a recording holds one.

    Cost: 3 s to prepare.
    """
    try:
        conditions = conditions_of(factors, row)
        setup = setup_of(str(row["robot"]), conditions, int(number_or(row["seed"], 0)))
    except (KeyError, TypeError, ValueError) as error:
        raise UsageError("the row is of no case of this study", value=error) from error
    if setup.believed is not None:
        raise UsageError(
            "the controller of this case believes another map than the skin's, and a recording holds one map",
            value=f"{row['factor']} {row['level']}",
            remedy="Choose a row of a factor that leaves the map as it is, such as rate, delay or noise",
        )
    settings = settings_of(conditions, QUICK_SIZE if row.get("quick") else None)
    speed = number_or(row["speed_mm_s"], 1e3 * SLOWEST) / 1e3
    seconds = number_or(row["seconds"], path_length(settings) / speed)
    tick = setup.prepared.scene.tick
    settling = round(SETTLING / tick)
    return CaseReplay(
        setup.session(replace(settings, path_speed=0.0)),
        settling + round(seconds / tick),
        {settling: ControlChanged(replace(settings, path_speed=speed))},
    )
