"""Do the controllers do what the theory of sampled loops says, with ideal joints and in the simulator?

The cases of every figure, one row each (measured, theory, theory with the posture loop), and the figures with why the
simulator departs where it does. It was the study ``control-theory``; what it promises is held by
``test_control_against_theory``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from app.control.controllers import CONTROL_SCHEMES
from app.studies.figures import Figure, Panel
from app.studies.study import Case, Row, Study
from app.studies.testbeds.path_following import SKIN_LINKS
from tests.numerics.control_theory.predictions import (
    COMPARISONS,
    FAST_SERVO,
    IDEAL_JOINTS,
    INTEGRAL_CONTROLLERS,
    LAGGING_JOINTS,
    OUR_SERVO,
    PERIOD,
    PLANTS,
)

_THEORY, _EXTENDED_THEORY = "theory", "theory with that loop"


@dataclass(frozen=True)
class FigureText:
    """How a figure is drawn, and why it departs from the theory.

    Attributes:
        title, x, y: As ``Figure`` has them.
        why: What makes the simulator depart, in a line.
    """

    title: str
    x: str
    y: str
    why: str


FIGURES: Mapping[str, FigureText] = {
    "stability": FigureText(
        "Greatest stable gain: L < 2 sin(π / (2 (2 d + 1)))",
        "delay d + 1/2 [samples]",
        "loop gain L",
        "At 40 rad/s the posture loop is still under way when the next reading is taken, which calms what would "
        "alternate (place, no delay); at 400 rad/s it is not.",
    ),
    "onset": FigureText(
        "Stiffness of a contact at which a force gain is too much: L / (k T)",
        "delay d + 1/2 [samples]",
        "onset stiffness [N/m]",
        "The posture loop gives way as a spring of 6.4 kN/m in series with the contact; at 400 rad/s it is one of "
        "640 kN/m.",
    ),
    "settling": FigureText(
        "Settling to 2 % at the gain without overshoot: 6.4 (d + 1/2) T",
        "(d + 1/2) T [s]",
        "settling time [s]",
        "The posture loop's lag of 50 ms overshoots without delay and hides in a longer one; at 400 rad/s it is gone.",
    ),
    "ripple": FigureText(
        "Ripple of the true force against settling: half of it costs four times as long",
        "settling time T ln 50 / -ln(1 - L) [s]",
        "ripple, of the noise read",
        "Nothing departs but by chance: runs are finite.",
    ),
    "routh": FigureText(
        "Shortest stable integral time of the parallel controller: k_I k_e < k_D (k_P + k_F k_e)",
        "position gain k_P [1/s]",
        "integral time [s]",
        "The posture loop lags by 50 ms; at 400 rad/s what is left is that the simulated contact bears half of what"
        " accelerates the plate.",
    ),
    "behind": FigureText(
        "Behind a goal that moves by 1 mm/s: v T / L, at the gain without overshoot",
        "delay d + 1/2 [samples]",
        "behind or ahead [mm]",
        "The goal is known at once and the place late, so in truth the contact is nearer by v d T, or ahead if the "
        "controller is told the speed; and the goal goes on between readings where ticks are shorter than the period.",
    ),
    "stretch": FigureText(
        "Settling on a stretched map, the slower direction at the best gain, d = 1",
        "stretch, greater over lesser",
        "samples to 2 %",
        "The posture loop's lag of 50 ms; at 400 rad/s it is gone. A controller with the map's Jacobian pays nothing"
        " for stretch.",
    ),
    "turn": FigureText(
        "Settling where the map is believed to lie turned, at the best gain, d = 1",
        "turn [deg]",
        "samples to 2 %",
        "The posture loop's lag of 50 ms; at 400 rad/s it is gone.",
    ),
    "lag": FigureText(
        "Greatest stable gain of the force with joints that lag",
        "period of the skin T [s]",
        "gain k_f k_e [1/s]",
        "A lag of 30 ms, or the posture loop's on a contact of 2 kN/m, is a delay that no faster skin shortens; "
        "without delay it also smooths what would alternate.",
    ),
    "arms": FigureText(
        "Whole arms beside a ball, read every 5 ms: greatest stable force gain, measured against the arm's own theory",
        "theory with all joints [m/s/N]",
        "measured [m/s/N]",
        "Ideal joints would bear 0.07 m/s/N everywhere; the posture loop's lag, coupled joints and a controller's "
        "own lag (admittance, parallel) take the rest.",
    ),
}
"""All figures by name, in order."""


def figures(rows: Sequence[Row]) -> list[Figure]:
    """One figure for each controller of the theory; its note says where and why the simulator departs."""
    return [
        Figure(told.title, told.x, told.y, _panels(mine), least=1e-3, note=f"{told.why} {_largest_departures(mine)}")
        for name, told in FIGURES.items()
        if (mine := [row for row in rows if row["figure"] == name])
    ]


def _panels(rows: Sequence[Row]) -> list[Panel]:
    return [
        _panel(str(what), [row for row in rows if row["what"] == what])
        for what in dict.fromkeys(row["what"] for row in rows)
    ]


def _panel(what: str, rows: Sequence[Row]) -> Panel:
    key = "controller" if rows[0]["figure"] == "arms" else "plant"
    measured = {
        str(name): _points([row for row in rows if row[key] == name], "measured")
        for name in dict.fromkeys(row[key] for row in rows)
    }
    if key == "controller":
        return Panel(what, {"theory with all joints": _points(rows, "explained"), **measured})
    explained = _points([row for row in rows if row["plant"] == OUR_SERVO], "explained")
    curves = {_THEORY: _points(rows, "theory"), **measured, _EXTENDED_THEORY: explained}
    return Panel(what, {name: points for name, points in curves.items() if points})


def _points(rows: Sequence[Row], key: str) -> list[tuple[float, float]]:
    """In order; of several controllers all that differ."""
    return sorted({(_number(row["x"]), _number(row[key])) for row in rows})


def _plants(rows: Sequence[Row]) -> list[str]:
    return [str(plant) for plant in dict.fromkeys(row["plant"] for row in rows)]


def _largest_departures(rows: Sequence[Row]) -> str:
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


DELAYS = range(5)
_LOOPS = ("force", "place")
_STRETCHES, _TURNS = (1.18, 1.55, 2.0, 3.0, 5.0), (5.0, 15.0, 30.0, 45.0, 60.0, 75.0)

CasePoint = dict[str, object]


def cases(quick: bool, seed: int) -> list[Case]:
    """Every figure's points, for ideal joints and simulated ones."""
    delays = (0, 2) if quick else tuple(DELAYS)
    found = _points_of_controllers(delays)
    for plant in (IDEAL_JOINTS, OUR_SERVO) if quick else PLANTS:
        points = [point for delay in delays for point in _points_per_delay(delay)]
        points += [*_points_without_delay(quick), *_points_of_one_delay(plant, quick)]
        found += [{"plant": plant, **point} for point in points]
    found += _points_with_lag(quick) + _points_of_arms(quick)
    return [{"figure": "", "what": "force", "controller": "hybrid", "delay": 1, **case, "seed": seed} for case in found]


def _points_per_delay(delay: int) -> list[CasePoint]:
    loops: list[CasePoint] = [{"figure": name, "what": what} for name in ("stability", "settling") for what in _LOOPS]
    loops += [{"figure": "onset", "what": "force"}]
    loops += [{"figure": "behind", "what": what} for what in ("as seen", "in truth", "in truth, told of it")]
    return [{**loop, "delay": delay, "x": delay + 0.5} for loop in loops]


def _points_without_delay(quick: bool) -> list[CasePoint]:
    """Ripple at loop gains; Routh's bound at position gains."""
    samples, gains = (100, (0.2, 0.4)) if quick else (800, (0.05, 0.1, 0.2, 0.4))
    noisy: list[CasePoint] = [{"figure": "ripple", "delay": 0, "x": gain, "samples": samples} for gain in gains]
    places, times = ((10.0,), (0.2,)) if quick else ((1.0, 3.0, 10.0), (0.2, 0.4))
    bound: CasePoint = {"figure": "routh", "controller": "parallel", "delay": 0}
    bounds = [{**bound, "x": x, "inertia": t, "what": f"inertia time {t:g} s"} for t in times for x in places]
    return [*noisy, *bounds]


def _points_of_one_delay(plant: str, quick: bool) -> list[CasePoint]:
    """Maps stretched and turned; a posture loop that is asked more and more often."""
    stretches, turns = ((2.0,), (30.0,)) if quick else (_STRETCHES, _TURNS)
    shaped: list[CasePoint] = [
        {"figure": "stretch", "what": controller, "controller": controller, "x": x}
        for controller in ("projection", "hybrid")
        for x in stretches
    ]
    shaped += [{"figure": "turn", "what": "place", "x": x} for x in turns]
    often = _periods(quick) if plant != FAST_SERVO else ()
    return shaped + [{"figure": "lag", "what": "posture loop, d = 1", "x": period} for period in often]


def _points_of_controllers(delays: Sequence[int]) -> list[CasePoint]:
    """The onset of all other controllers, with ideal joints."""
    controllers = [controller for controller in INTEGRAL_CONTROLLERS if controller != "hybrid"]
    point: CasePoint = {"plant": IDEAL_JOINTS, "figure": "onset", "what": "force"}
    return [
        {**point, "controller": controller, "delay": delay, "x": delay + 0.5}
        for controller in controllers
        for delay in delays
    ]


def _points_with_lag(quick: bool) -> list[CasePoint]:
    """Ideal joints that lag."""
    point: CasePoint = {"plant": LAGGING_JOINTS, "figure": "lag"}
    delays = (0, 1)
    return [
        {**point, "what": f"{LAGGING_JOINTS}, d = {d}", "x": t, "delay": d} for t in _periods(quick) for d in delays
    ]


def _points_of_arms(quick: bool) -> list[CasePoint]:
    """Whole robots beside a ball."""
    robots, controllers = (("arm",), ("hybrid",)) if quick else (tuple(SKIN_LINKS), tuple(CONTROL_SCHEMES))
    point: CasePoint = {"figure": "arms", "delay": 0, "x": 0.0}
    return [
        {"plant": robot, **point, "what": robot, "robot": robot, "controller": controller}
        for robot in robots
        for controller in controllers
    ]


def _periods(quick: bool) -> tuple[float, ...]:
    return (0.25,) if quick else (0.02, 0.05, 0.1, 0.25, 1.0)


def measure(case: Case) -> list[Row]:
    """One row: what was measured and what both theories say, and how far it is off each [%]."""
    measured, predicted, explained = COMPARISONS[case["figure"]](case)
    x = case["x"]
    if case["figure"] == "ripple":
        x = 0.02 * math.log(50) / -math.log1p(-case["x"])
    elif case["figure"] == "settling":
        x = PERIOD * case["x"]
    elif case["figure"] == "arms":
        x = explained
    return [
        {
            "x": x,
            "measured": measured,
            "theory": predicted,
            "explained": explained,
            "off_percent": _percent_off(measured, predicted),
            "explained_off_percent": _percent_off(measured, explained),
        }
    ]


def _percent_off(measured: float, predicted: float) -> float | None:
    return 100 * (measured / predicted - 1) if predicted else None


STUDY = Study(
    "control-theory",
    "Do the controllers do what the theory of sampled loops says, and where the simulator departs, why?",
    "A plate of skin of 4 kg on three slides is pressed on a ball that stands still, without friction. Joints are "
    "ideal, or simulated under the posture loop of 40 rad/s of all controllers, or under one ten times as fast. The "
    "skin is read every 0.25 s unless said otherwise, late by whole periods. Each loop comes to rest at a calm gain; "
    "then a goal is moved. A loop counts as unstable when errors grow; limits are found to 3 %. The theory is that of"
    " ideal joints; the other line has the posture loop, the plate's mass and the contact's own spring and damper in "
    "it.",
    cases,
    measure,
    figures,
)
