"""Work-precision: error against milliseconds, and settings to choose by it.

A stage of the program (cutting, flattening, the image, touch, simulation, control) lists the settings worth trying,
tries one, and says which is in force. ``run_trials`` tries them all on the user's own skin, ``diagram`` draws what came
out: one curve a method, in one of the stage's errors; ``pareto_front`` are the settings that no other beats in both. A
further stage is one entry in ``stages.registry``.

Studies in ``sweeps`` make the same trials on subjects whose truth is known: ``trial_row`` is a trial in their tables,
``work_precision_figures`` are their diagrams. ``timed`` is the one stopwatch.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Generic, TypeVar

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import TactileMapsError
from tactile_maps.core.progress import Progress
from tactile_maps.flattening.chart import Chart
from tactile_maps.flattening.cut import SeamPlan
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.studies.base.figures import Figure, panels
from tactile_maps.studies.base.rows import Cell, Row

Value = str | int | float
_LAW_POINTS = 16
Result = TypeVar("Result")


@dataclass(frozen=True, eq=False)
class PatchRecipe:
    """How a patch is flattened; pins are left out.

    Attributes:
        method: A name in ``flattening.methods``, or how a chart that came from elsewhere was made.
        lengths: From 1, keep lengths, to 0, keep angles.
        seams: Drawn and further seams, and areas of interest.
        added: How many seams its chart has besides drawn ones and those that its topology asks for.
    """

    method: str
    lengths: float = 1.0
    seams: SeamPlan = field(default_factory=SeamPlan)
    added: int = 0


@dataclass(frozen=True)
class Subject:
    """What is measured: a map, or some patches of it.

    Attributes:
        map: As it is.
        patches: Numbers of the patches meant; all that a stage of single patches flattens.
        recipes: How each patch of the map was flattened.
        names: Of all patches of the map, as shown.
        prepared: The robot that the map's skin covers, for what moves; None where only the map is known.
    """

    map: TactileMap
    patches: tuple[int, ...]
    recipes: tuple[PatchRecipe, ...]
    names: tuple[str, ...]
    prepared: PreparedScene | None = None

    @classmethod
    def of(
        cls, map_: TactileMap, patches: Iterable[int] | None = None, *, prepared: PreparedScene | None = None
    ) -> Subject:
        """A map as it was built, with all its patches or those named."""
        recipes = tuple(PatchRecipe(chart.method, added=seams_added(chart)) for chart in map_.charts)
        names = tuple(patch.name for patch in map_.skin.patches)
        return cls(map_, tuple(range(len(names)) if patches is None else patches), recipes, names, prepared)

    @property
    def faces(self) -> int:
        """Triangles of the patches."""
        return sum(len(self.map.skin.patches[k].surface.faces) for k in self.patches)

    @property
    def title(self) -> str:
        """The patches in few words."""
        names = [self.names[k] for k in self.patches]
        if len(names) > 1:
            return "all patches" if len(names) == len(self.names) else f"{len(names)} patches"
        return names[0] if names else "no patch"


def seams_added(chart: Chart) -> int:
    """How many seams a chart was given because they were worth it."""
    return sum(found.count for found in chart.findings if found.kind == "seam-added")


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
class StabilityLimit:
    """How far a method is predicted to be stable, as one of its settings grows.

    Attributes:
        name: In a legend.
        source: The formula, where it comes from and what it leaves out, in a sentence.
        key: Of the setting, among its ``values``.
        value: The greatest that is stable.
    """

    name: str
    source: str
    key: str
    value: float


@dataclass(frozen=True)
class Trial:
    """One setting tried.

    Attributes:
        setting: What was tried.
        name: What is special about it, in a few words after the method's name; may be empty.
        milliseconds: What it took; None where it could not be done.
        errors: By the stage's keys, in the units shown; None where there was nothing to measure one by.
        note: What had to be done besides, or why it could not be done.
        usable: Whether it can be chosen; a round on the way of an iterative method cannot.
        joined: Whether it belongs to the method's line.
        p95_ms: 95 % of the runs took less [ms]; None where it was not done often enough to tell.
        intervals: By error's key, between what that of all places lies, of which some were tried (95 %); none where
            all of it was looked at, or one place.
        limit: How far the setting's method is stable; None where nothing is known to end it.
    """

    setting: Setting
    name: str
    milliseconds: float | None
    errors: Mapping[str, float | None]
    note: str = ""
    usable: bool = True
    joined: bool = True
    p95_ms: float | None = None
    intervals: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    limit: StabilityLimit | None = None


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
class Law:
    """What theory says of a stage's error in so many milliseconds.

    Attributes:
        name: In a legend.
        source: The formula, where it comes from and what it leaves out, in a sentence.
        error: In the units shown, of (k,) milliseconds.
    """

    name: str
    source: str
    error: Callable[[FloatArray], FloatArray]


def _without_theory(_subject: Subject, _error: str) -> Sequence[Law]:
    return ()


def _not_in_the_map(_subject: Subject) -> None:
    return


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
        fingerprint: In few letters what the trials depend on, so that one can tell when they are out of date.
        seconds: About how long all of it takes.
        certainty: What the upright lines at its points are the intervals of, or why there are none, in a sentence.
        current: The setting in force; None where there is none, or it is the scene's and not the map's.
        recipes: How a setting's patches are flattened, with their numbers; None where a setting is no edit of the map.
        laws: Closed forms of one of its errors, by key, to be drawn under what was measured.
    """

    name: str
    title: str
    question: str
    methods: tuple[str, ...]
    errors: tuple[ErrorKind, ...]
    settings: Callable[[Subject], Sequence[Setting]]
    trials: Callable[[Subject, Setting], Iterable[Trial]]
    fingerprint: Callable[[Subject], str]
    seconds: Callable[[Subject], float]
    certainty: str
    current: Callable[[Subject], Setting | None] = _not_in_the_map
    recipes: Callable[[Subject, Setting], Sequence[tuple[int, PatchRecipe]]] | None = None
    laws: Callable[[Subject, str], Sequence[Law]] = _without_theory


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
    p95_ms: float | None = None
    interval: tuple[float, float] | None = None


@dataclass(frozen=True)
class Curve:
    """One method's points, in the order in which they are joined; ``number`` is the method's among all of the stage."""

    method: str
    points: tuple[Point, ...]
    number: int = 0


@dataclass(frozen=True)
class LawCurve:
    """A closed form as it is drawn: ``points`` are pairs of milliseconds and error; see ``Law``."""

    name: str
    source: str
    points: tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class LimitLine:
    """Where a method's limit of stability lies; see ``StabilityLimit``.

    Attributes:
        name: In a legend.
        source: As the limit has it.
        milliseconds: What the method takes there, between the points that were measured or as they go on.
        number: The method's among all of the stage.
    """

    name: str
    source: str
    milliseconds: float
    number: int


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
        laws: Closed forms, from the fastest to the slowest point: each with (k, 2) milliseconds and error.
        limits: Where methods stop being stable.
    """

    stage: str
    title: str
    error_name: str
    unit: str
    curves: tuple[Curve, ...]
    least: float = 1e-9
    missing: tuple[str, ...] = ()
    laws: tuple[LawCurve, ...] = ()
    limits: tuple[LimitLine, ...] = ()

    @property
    def points(self) -> tuple[Point, ...]:
        """Those of all curves."""
        return tuple(point for curve in self.curves for point in curve.points)


def run_trials(stage: Stage, subject: Subject, *, progress: Progress) -> Iterator[Trial]:
    """Try every setting of a stage, one after the other; one that cannot be done says so and the others go on.

    The first is tried once more before all: whoever computes for the first time waits for memory and libraries.

    Args:
        stage: An entry of ``stages.registry``.
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
        return [Trial(setting, "", None, {}, note=str(error), usable=False)]


def diagram(stage: Stage, trials: Iterable[Trial], *, error: str = "", subject: Subject | None = None) -> Diagram:
    """The curves of ``trials`` in one of the stage's errors, by default the first; what has no such error stays out.

    Of a ``subject`` also what theory says.
    """
    trials = tuple(trials)
    kind = next((kind for kind in stage.errors if kind.key == error), stage.errors[0])
    found: dict[str, list[Point]] = {}
    missing = []
    for trial in trials:
        took = trial.milliseconds
        value = trial.errors.get(kind.key)
        if value is not None and math.isfinite(value) and took is not None and took > 0:
            told = (trial.setting, trial.name, trial.note, trial.usable, trial.joined, trial.p95_ms)
            point = Point(took, value, *told, trial.intervals.get(kind.key))
            found.setdefault(trial.setting.method, []).append(point)
        elif not trial.errors:
            missing.append(f"{method_title(trial.setting.method)}: {trial.note}")
    order = sorted(found, key=stage.methods.index)
    curves = tuple(Curve(method, tuple(found[method]), stage.methods.index(method)) for method in order)
    laws = () if subject is None else _law_curves(stage.laws(subject, kind.key), curves)
    unmade = tuple(dict.fromkeys(missing))
    limits = tuple(_limit_lines(curves, trials))
    return Diagram(stage.name, stage.title, kind.name, kind.unit, curves, kind.least, unmade, laws, limits)


def _limit_lines(curves: Iterable[Curve], trials: Sequence[Trial]) -> Iterator[LimitLine]:
    """Of each method that has a limit and two points: time against the setting is a power law from point to point."""
    for curve in curves:
        limit = next((trial.limit for trial in trials if trial.limit and trial.setting.method == curve.method), None)
        if limit is None:
            continue
        rows = {float(point.setting.values[limit.key]): point.milliseconds for point in curve.points}
        if len(rows) < 2:
            continue
        values, times = np.log(np.array(sorted(rows.items()))).T
        k = int(np.clip(np.searchsorted(values, math.log(limit.value)), 1, len(values) - 1))
        slope = (times[k] - times[k - 1]) / (values[k] - values[k - 1])
        there = math.exp(float(times[k] + slope * (math.log(limit.value) - values[k])))
        yield LimitLine(limit.name, limit.source, there, curve.number)


def _law_curves(laws: Iterable[Law], curves: Iterable[Curve]) -> tuple[LawCurve, ...]:
    times = [point.milliseconds for curve in curves for point in curve.points]
    if not times:
        return ()
    along = np.geomspace(min(times), max(times), _LAW_POINTS)
    pairs = ((law, zip(along.tolist(), law.error(along).tolist(), strict=True)) for law in laws)
    return tuple(LawCurve(law.name, law.source, tuple(points)) for law, points in pairs)


def pareto_front(points: Iterable[Point]) -> tuple[Point, ...]:
    """The usable points that nobody beats in both time and error (Pareto), by time."""
    best: list[Point] = []
    for point in sorted((p for p in points if p.usable), key=lambda p: (p.milliseconds, p.error)):
        if not best or point.error < best[-1].error:
            best.append(point)
    return tuple(best)


@dataclass(frozen=True, eq=False)
class Timed(Generic[Result]):
    """An action done several times.

    Attributes:
        result: Of the run that took the middle time.
        seconds: (k,) of every run, in order.
    """

    result: Result
    seconds: tuple[float, ...]

    @property
    def ms(self) -> float:
        """The middle time [ms]; of two in the middle the shorter."""
        return 1e3 * sorted(self.seconds)[(len(self.seconds) - 1) // 2]

    @property
    def p95_ms(self) -> float:
        """95 % of the runs took less [ms]."""
        return 1e3 * float(np.percentile(self.seconds, 95))


def timed(
    action: Callable[[], Result],
    *,
    repeats: int = 3,
    budget: float = math.inf,
    warm_up: bool = False,
    clock: Callable[[], float] = time.perf_counter,
) -> Timed[Result]:
    """Do ``action`` by the clock ``repeats`` times, or until ``budget`` [s] is spent; once more before to warm up."""
    if warm_up:
        action()
    results: list[Result] = []
    seconds: list[float] = []
    while len(seconds) < repeats and sum(seconds) < budget:
        start = clock()
        results.append(action())
        seconds.append(clock() - start)
    middle = sorted(range(len(seconds)), key=seconds.__getitem__)[(len(seconds) - 1) // 2]
    return Timed(results[middle], tuple(seconds))


def trial_row(trial: Trial) -> dict[str, Cell]:
    """A trial as columns of a study's table; what it was tried with is the case's."""
    often = {} if trial.p95_ms is None else {"p95_ms": trial.p95_ms}
    return {"ms": trial.milliseconds, **often, **trial.errors, "note": trial.note}


def work_precision_figures(
    rows: Sequence[Row],
    errors: Iterable[ErrorKind],
    *,
    panel: Callable[[Row], str],
    method: Callable[[Row], str] = lambda row: str(row["method"]),
    x: str = "ms",
    x_name: str = "milliseconds",
    title: str = "{}",
) -> list[Figure]:
    """Error against time, a figure for each kind of error, in it a panel for each subject and a curve for each method.

    Args:
        rows: Of a study; points are joined in their order.
        errors: Whose keys are columns.
        panel: Title of the panel of a row.
        method: Name of the curve of a row.
        x: Column of the time.
        x_name: As shown.
        title: Of a figure; braces stand for the error's name.
    """
    return [
        Figure(
            title.format(kind.name), x_name, kind.unit, panels(rows, panel, method, x=x, y=kind.key), least=kind.least
        )
        for kind in errors
    ]


_TITLES = {
    "symmetric-dirichlet": "Symmetric Dirichlet",
    "lscm": "Conformal (LSCM)",
    "arap": "As rigid as possible",
    "slim": "SLIM",
}


def method_title(name: str) -> str:
    """A method's name as it is shown to people."""
    return _TITLES.get(name, name.replace("-", " ").capitalize())
