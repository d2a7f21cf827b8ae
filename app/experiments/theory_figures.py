"""How the figures of control against theory are drawn, and why the simulator departs where it does."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from app.experiments.plot import Figure, Panel
from app.experiments.sweep import Row
from app.experiments.theory_rows import IDEAL_JOINTS, OURS

_THEORY, _EXPLAINED = "theory", "theory with that loop"


@dataclass(frozen=True)
class Told:
    """How a figure is drawn, and why it departs from the theory.

    Attributes:
        title, x, y: As ``Figure`` has them.
        why: What makes the simulator depart, in a line.
    """

    title: str
    x: str
    y: str
    why: str


FIGURES: Mapping[str, Told] = {
    "stability": Told(
        "Greatest stable gain: L < 2 sin(π / (2 (2 d + 1)))",
        "delay d + 1/2 [samples]",
        "loop gain L",
        "At 40 rad/s the posture loop is still under way when the next reading is taken, which calms what would "
        "alternate (place, no delay); at 400 rad/s it is not.",
    ),
    "onset": Told(
        "Stiffness of a contact at which a force gain is too much: L / (k T)",
        "delay d + 1/2 [samples]",
        "onset stiffness [N/m]",
        "The posture loop gives way as a spring of 6.4 kN/m in series with the contact; at 400 rad/s it is one of "
        "640 kN/m.",
    ),
    "settling": Told(
        "Settling to 2 % at the gain without overshoot: 6.4 (d + 1/2) T",
        "(d + 1/2) T [s]",
        "settling time [s]",
        "The posture loop's lag of 50 ms overshoots without delay and hides in a longer one; at 400 rad/s it is gone.",
    ),
    "ripple": Told(
        "Ripple of the true force against settling: half of it costs four times as long",
        "settling time T ln 50 / -ln(1 - L) [s]",
        "ripple, of the noise read",
        "Nothing departs but by chance: runs are finite.",
    ),
    "routh": Told(
        "Shortest stable integral time of the parallel law: k_I k_e < k_D (k_P + k_F k_e)",
        "position gain k_P [1/s]",
        "integral time [s]",
        "The posture loop lags by 50 ms; at 400 rad/s what is left is that the simulated contact bears half of what"
        " accelerates the plate.",
    ),
    "behind": Told(
        "Behind a goal that moves by 1 mm/s: v T / L, at the gain without overshoot",
        "delay d + 1/2 [samples]",
        "behind or ahead [mm]",
        "The goal is known at once and the place late, so in truth the contact is nearer by v d T, or ahead if the "
        "law is told the speed; and the goal goes on between readings where ticks are shorter than the period.",
    ),
    "stretch": Told(
        "Settling on a stretched map, the slower direction at the best gain, d = 1",
        "stretch, greater over lesser",
        "samples to 2 %",
        "The posture loop's lag of 50 ms; at 400 rad/s it is gone. A law that knows the map's Jacobian pays nothing"
        " for stretch.",
    ),
    "turn": Told(
        "Settling where the map is believed to lie turned, at the best gain, d = 1",
        "turn [deg]",
        "samples to 2 %",
        "The posture loop's lag of 50 ms; at 400 rad/s it is gone.",
    ),
    "lag": Told(
        "Greatest stable gain of the force with joints that lag",
        "period of the skin T [s]",
        "gain k_f k_e [1/s]",
        "A lag of 30 ms, or the posture loop's on a contact of 2 kN/m, is a delay that no faster skin shortens; "
        "without delay it also smooths what would alternate.",
    ),
    "arms": Told(
        "Whole arms beside a ball, read every 5 ms: greatest stable force gain, measured against the arm's own theory",
        "theory with all joints [m/s/N]",
        "measured [m/s/N]",
        "Ideal joints would bear 0.07 m/s/N everywhere; the posture loop's lag, the coupling of joints and a law's "
        "own lag (admittance, parallel) take the rest.",
    ),
}
"""All figures by name, in order."""


def figures(rows: Sequence[Row]) -> list[Figure]:
    """One figure for each law of the theory; its note says where and why the simulator departs."""
    return [
        Figure(told.title, told.x, told.y, _panels(mine), least=1e-3, note=f"{told.why} {_departures(mine)}")
        for name, told in FIGURES.items()
        if (mine := [row for row in rows if row["figure"] == name])
    ]


def _panels(rows: Sequence[Row]) -> list[Panel]:
    return [
        _panel(str(what), [row for row in rows if row["what"] == what])
        for what in dict.fromkeys(row["what"] for row in rows)
    ]


def _panel(what: str, rows: Sequence[Row]) -> Panel:
    key = "law" if rows[0]["figure"] == "arms" else "plant"
    measured = {
        str(name): _points([row for row in rows if row[key] == name], "measured")
        for name in dict.fromkeys(row[key] for row in rows)
    }
    if key == "law":
        return Panel(what, {"theory with all joints": _points(rows, "explained"), **measured})
    explained = _points([row for row in rows if row["plant"] == OURS], "explained")
    curves = {_THEORY: _points(rows, "theory"), **measured, _EXPLAINED: explained}
    return Panel(what, {name: points for name, points in curves.items() if points})


def _points(rows: Sequence[Row], key: str) -> list[tuple[float, float]]:
    """In order; of several laws all that differ."""
    return sorted({(_number(row["x"]), _number(row[key])) for row in rows})


def _plants(rows: Sequence[Row]) -> list[str]:
    return [str(plant) for plant in dict.fromkeys(row["plant"] for row in rows)]


def _departures(rows: Sequence[Row]) -> str:
    """The greatest of each plant, in words."""
    said = []
    for plant in _plants(rows):
        mine = [row for row in rows if row["plant"] == plant]
        off, left = (max((abs(_number(row[key])) for row in mine if row[key] is not None), default=math.nan)
                     for key in ("off_percent", "explained_off_percent"))  # fmt: skip
        if math.isfinite(off):
            said.append(
                f"{plant} {off:.0f} %" + (f", {left:.0f} % of the theory with it" if plant != IDEAL_JOINTS else "")
            )
    return f"Farthest off: {'; '.join(said)}." if said else ""


def _number(value: object) -> float:
    return float(value) if isinstance(value, int | float) else math.nan
