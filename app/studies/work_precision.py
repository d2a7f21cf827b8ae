"""Work-precision on the user's own skin: error against milliseconds, and settings to choose by it.

A stage of the program (cutting, flattening, the image, touch, simulation, control) lists the settings worth trying,
tries one, and says which is in force. ``run_trials`` tries them all, ``diagram`` draws what came out: one curve a
method, in one of the stage's errors; ``pareto_front`` are the settings that no other beats in both. A further stage is
one entry in ``stages.registry``.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeVar

from app.core.errors import TactileMapsError
from app.editing.document import MapDocument
from app.editing.reflatten import ReflattenRequest
from app.session.prepare import PreparedScene

_RUNS, _ENOUGH = 3, 0.2

Value = str | int | float
Progress = Callable[[str, float], None]
Result = TypeVar("Result")


@dataclass(frozen=True)
class Subject:
    """What is measured: the present map, or some patches of it.

    Attributes:
        document: The map as it is.
        patches: Numbers of the patches meant; all that a stage of single patches lays flat.
        prepared: The robot that wears the map's skin, for what moves; None where only the map is known.
    """

    document: MapDocument
    patches: tuple[int, ...]
    prepared: PreparedScene | None = None

    @property
    def faces(self) -> int:
        """Triangles of the patches."""
        return sum(len(self.document.skin.patches[k].surface.faces) for k in self.patches)

    @property
    def title(self) -> str:
        """The patches in few words."""
        names = [self.document.patches[k].name for k in self.patches]
        if len(names) > 1:
            return "all patches" if len(names) == len(self.document.patches) else f"{len(names)} patches"
        return names[0] if names else "no patch"


@dataclass(frozen=True)
class Setting:
    """What a person can choose in a stage.

    Attributes:
        stage: Its name.
        method: The method's name.
        values: Whatever else makes the setting; which keys, the stage says.
        patches: The patches it is for; none where it is for the whole map.
    """

    stage: str
    method: str
    values: Mapping[str, Value] = field(default_factory=dict)
    patches: tuple[int, ...] = ()


@dataclass(frozen=True)
class Trial:
    """One setting tried.

    Attributes:
        setting: What was tried.
        name: What is special about it, in a few words after the method's name; may be empty.
        milliseconds: What it took; nan where it could not be done.
        errors: By the stage's keys, in the units shown.
        note: What had to be done besides, or why it could not be done.
        usable: Whether it can be chosen; a round on the way of an iterative method cannot.
        joined: Whether it belongs to the method's line.
    """

    setting: Setting
    name: str
    milliseconds: float
    errors: Mapping[str, float]
    note: str = ""
    usable: bool = True
    joined: bool = True


@dataclass(frozen=True)
class ErrorKind:
    """One way to be wrong.

    Attributes:
        key: In the trials.
        name: As shown.
        unit: As shown.
        tip: What it means, for somebody who never saw the word.
        least: Smaller errors are drawn here: a logarithm knows no zero.
    """

    key: str
    name: str
    unit: str
    tip: str
    least: float


@dataclass(frozen=True)
class Stage:
    """One part of the way from skin to image.

    Attributes:
        name: In settings.
        title: As shown.
        question: What its diagram answers, in one sentence.
        methods: Names of all methods it may have; a method keeps its colour by its place here.
        errors: In which its diagram can be drawn; the first is what it is about.
        settings: Those worth trying, the present one among them where it can be tried.
        trials: Tries one; the last trial is the setting's own. Raises a named error where it cannot be done.
        current: The setting in force; None where there is none, or it is not in the document.
        fingerprint: In few letters what the trials depend on, so that one can tell when they are out of date.
        seconds: About how long all of it takes.
        reflatten: What the editor must compute for a setting to be in force; None where it is no edit of the map.
    """

    name: str
    title: str
    question: str
    methods: tuple[str, ...]
    errors: tuple[ErrorKind, ...]
    settings: Callable[[Subject], Sequence[Setting]]
    trials: Callable[[Subject, Setting], Iterable[Trial]]
    current: Callable[[Subject], Setting | None]
    fingerprint: Callable[[Subject], str]
    seconds: Callable[[Subject], float]
    reflatten: Callable[[MapDocument, Setting], ReflattenRequest] | None = None


@dataclass(frozen=True)
class Point:
    """One point of a diagram; see ``Trial``."""

    milliseconds: float
    error: float
    setting: Setting
    name: str = ""
    note: str = ""
    usable: bool = True
    joined: bool = True


@dataclass(frozen=True)
class Curve:
    """One method's points, in the order in which they are joined; ``number`` is the method's among all of the stage."""

    method: str
    points: tuple[Point, ...]
    number: int = 0


@dataclass(frozen=True)
class Diagram:
    """Error against milliseconds.

    Attributes:
        stage: The stage's name.
        title: The stage's, as shown.
        error_name: What is wrong.
        unit: Of the error.
        curves: One a method.
        least: Smaller errors are drawn here.
        missing: What could not be done, and why.
    """

    stage: str
    title: str
    error_name: str
    unit: str
    curves: tuple[Curve, ...]
    least: float = 1e-9
    missing: tuple[str, ...] = ()

    @property
    def points(self) -> tuple[Point, ...]:
        """Those of all curves."""
        return tuple(point for curve in self.curves for point in curve.points)


def run_trials(stage: Stage, subject: Subject, *, progress: Progress) -> Iterator[Trial]:
    """Try every setting of a stage, one after the other; one that cannot be done says so and the others go on.

    The first is tried once more before all: whoever computes for the first time waits for memory and libraries.

    Args:
        stage: An entry of ``stages.table``.
        subject: What to try it on.
        progress: Told what is tried and how far it is, 0 to 1; may raise to cancel.
    """
    settings = stage.settings(subject)
    progress("warming up", 0.0)
    for setting in settings[:1]:
        _try_setting(stage, subject, setting)
    for number, setting in enumerate(settings):
        progress(f"trying {method_title(setting.method)}", number / len(settings))
        yield from _try_setting(stage, subject, setting)


def _try_setting(stage: Stage, subject: Subject, setting: Setting) -> list[Trial]:
    try:
        return list(stage.trials(subject, setting))
    except TactileMapsError as error:
        return [Trial(setting, "", float("nan"), {}, note=str(error), usable=False)]


def diagram(stage: Stage, trials: Iterable[Trial], *, error: str = "") -> Diagram:
    """The curves of ``trials`` in one of the stage's errors, by default the first; what has no such error stays out."""
    kind = next((kind for kind in stage.errors if kind.key == error), stage.errors[0])
    found: dict[str, list[Point]] = {}
    missing = []
    for trial in trials:
        value = trial.errors.get(kind.key, math.nan)
        if math.isfinite(value) and trial.milliseconds > 0:
            point = Point(trial.milliseconds, value, trial.setting, trial.name, trial.note, trial.usable, trial.joined)
            found.setdefault(trial.setting.method, []).append(point)
        elif not trial.errors:
            missing.append(f"{method_title(trial.setting.method)}: {trial.note}")
    order = sorted(found, key=stage.methods.index)
    curves = tuple(Curve(method, tuple(found[method]), stage.methods.index(method)) for method in order)
    return Diagram(stage.name, stage.title, kind.name, kind.unit, curves, kind.least, tuple(dict.fromkeys(missing)))


def pareto_front(points: Iterable[Point]) -> tuple[Point, ...]:
    """The usable points that nobody beats in both time and error (Pareto), by time."""
    best: list[Point] = []
    for point in sorted((p for p in points if p.usable), key=lambda p: (p.milliseconds, p.error)):
        if not best or point.error < best[-1].error:
            best.append(point)
    return tuple(best)


def median_run(
    action: Callable[[], Result],
    *,
    most: int = _RUNS,
    enough: float = _ENOUGH,
    clock: Callable[[], float] = time.perf_counter,
) -> tuple[Result, float]:
    """Do ``action`` ``most`` times, or until ``enough`` seconds are spent: result and seconds of the middle run."""
    runs: list[tuple[float, Result]] = []
    while len(runs) < most and sum(seconds for seconds, _ in runs) < enough:
        start = clock()
        made = action()
        runs.append((clock() - start, made))
    seconds, made = sorted(runs, key=lambda run: run[0])[(len(runs) - 1) // 2]
    return made, seconds


_TITLES = {
    "symmetric-dirichlet": "Balanced",
    "lscm": "Conformal (LSCM)",
    "arap": "As rigid as possible",
    "slim": "SLIM",
}


def method_title(name: str) -> str:
    """A method's name as it is shown to people."""
    return _TITLES.get(name, name.replace("-", " ").capitalize())
