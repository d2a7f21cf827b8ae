"""Work-precision: error against milliseconds, as a basis for choosing settings.

A stage of the program (cutting, flattening, image, touch, simulation, control) lists the settings worth trying, tries
one of them, and reports the current one. ``run_trials`` tries all of them on the user's own skin. ``diagram`` draws the
trials, one curve a method, in one of the errors of the stage. ``pareto_front`` selects the settings that no other
setting beats in both time and error. A new stage is one entry in ``stages.registry``.

Studies in ``sweeps`` make the same trials on subjects with known truth: ``trial_row`` converts a trial to a row of
their tables, ``work_precision_figures`` draws their diagrams. All times are measured by ``timed``.
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
_THEORY_POINTS = 16
Result = TypeVar("Result")


@dataclass(frozen=True, eq=False)
class PatchRecipe:
    """Settings by which a patch is flattened, without pins.

    Attributes:
        method: A name in ``flattening.methods``, or the origin of an imported chart.
        lengths: 1 to preserve lengths, 0 to preserve angles.
        seams: Drawn and additional seams, and areas of interest.
        added: Number of seams of the chart beyond the drawn ones and those that its topology requires.
    """

    method: str
    lengths: float = 1.0
    seams: SeamPlan = field(default_factory=SeamPlan)
    added: int = 0


@dataclass(frozen=True)
class Subject:
    """Object of a measurement: a map, or some patches of it.

    Attributes:
        map: The map.
        patches: Numbers of the selected patches; stages that flatten single patches use only these.
        recipes: How each patch of the map was flattened.
        names: Displayed names of all patches of the map.
        prepared: Robot that the skin of the map covers, for stages that need one; None where only the map is known.
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
        """Create a subject from an unedited map, with all of its patches or the given ones."""
        recipes = tuple(PatchRecipe(chart.method, added=seams_added(chart)) for chart in map_.charts)
        names = tuple(patch.name for patch in map_.skin.patches)
        return cls(map_, tuple(range(len(names)) if patches is None else patches), recipes, names, prepared)

    @property
    def faces(self) -> int:
        """Number of triangles of the selected patches."""
        return sum(len(self.map.skin.patches[k].surface.faces) for k in self.patches)

    @property
    def title(self) -> str:
        """Short description of the selected patches."""
        names = [self.names[k] for k in self.patches]
        if len(names) > 1:
            return "all patches" if len(names) == len(self.names) else f"{len(names)} patches"
        return names[0] if names else "no patch"


def seams_added(chart: Chart) -> int:
    """Return the number of seams that were added to a chart because they reduce distortion enough."""
    return sum(found.count for found in chart.findings if found.kind == "seam-added")


@dataclass(frozen=True)
class Setting:
    """A choice in a stage.

    Attributes:
        stage: Name of the stage.
        method: Name of the method.
        values: Further parameters; the stage defines their keys.
        patches: Patches that it applies to; empty for the whole map.
    """

    stage: str
    method: str
    values: Mapping[str, Value] = field(default_factory=dict)
    patches: tuple[int, ...] = ()


@dataclass(frozen=True)
class StabilityLimit:
    """Predicted stability limit of a method in one of its parameters.

    Attributes:
        name: Name in a legend.
        source: The formula, its origin and its omissions, in a sentence.
        key: Key of the parameter in ``Setting.values``.
        value: Largest stable value.
    """

    name: str
    source: str
    key: str
    value: float


@dataclass(frozen=True)
class Trial:
    """Trial of one setting.

    Attributes:
        setting: The setting.
        name: Short description that follows the name of the method; may be empty.
        milliseconds: Duration; None where the trial failed.
        errors: Errors by key of the stage, in displayed units; None where an error could not be measured.
        note: Additional actions that were necessary, or the reason of the failure.
        usable: Whether the setting can be chosen; an intermediate round of an iterative method cannot.
        joined: Whether the point belongs to the line of its method.
        p95_ms: 95th percentile of the durations [ms]; None with too few repetitions.
        intervals: 95 % intervals of errors that were measured on a sample, by key; empty where everything, or one
            place only, was measured.
        limit: Stability limit of the method; None without a known limit.
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
    """A measure of error.

    Attributes:
        key: Key in trials.
        name: Displayed name.
        unit: Displayed unit.
        tip: Explanation for a reader who does not know the term.
        least: Smaller errors are drawn at this value, because a logarithmic axis has no zero.
    """

    key: str
    name: str
    unit: str
    tip: str
    least: float


@dataclass(frozen=True)
class Theory:
    """Theoretical error of a stage as a function of time.

    Attributes:
        name: Name in a legend.
        source: The formula, its origin and its omissions, in a sentence.
        error: Returns errors in displayed units for (k,) milliseconds.
    """

    name: str
    source: str
    error: Callable[[FloatArray], FloatArray]


def _without_theory(_subject: Subject, _error: str) -> Sequence[Theory]:
    return ()


def _not_part_of_the_map(_subject: Subject) -> None:
    return


@dataclass(frozen=True)
class Stage:
    """A step of the processing chain from skin to image, with its settings and errors.

    Attributes:
        name: Name in settings.
        title: Displayed title.
        question: Question that its diagram answers, in one sentence.
        methods: Names of all methods; the position of a method determines its colour.
        errors: Errors that its diagram can show, the main one first.
        settings: Settings worth trying, including the current one where it can be tried.
        trials: Tries a setting; the last trial is the result of the setting itself. Raises a TactileMapsError where
            that is not possible.
        fingerprint: Short text of everything that the trials depend on, to detect outdated trials.
        seconds: Approximate duration of all trials [s].
        certainty: Meaning of the error bars, or the reason for their absence, in a sentence.
        current: The current setting; None where there is none, or where it belongs to the scene and not to the map.
        recipes: How a setting flattens its patches, with their numbers; None where a setting does not edit the map.
        theory: Closed-form predictions of one of its errors, by key, which are drawn below the measurements.
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
    current: Callable[[Subject], Setting | None] = _not_part_of_the_map
    recipes: Callable[[Subject, Setting], Sequence[tuple[int, PatchRecipe]]] | None = None
    theory: Callable[[Subject, str], Sequence[Theory]] = _without_theory


@dataclass(frozen=True)
class Point:
    """A point of a diagram; see ``Trial``."""

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
    """Points of one method, in the order in which they are joined; ``number`` is the position of the method."""

    method: str
    points: tuple[Point, ...]
    number: int = 0


@dataclass(frozen=True)
class TheoryCurve:
    """Points (milliseconds, error) of a closed-form prediction; see ``Theory``."""

    name: str
    source: str
    points: tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class LimitLine:
    """Position of the stability limit of a method; see ``StabilityLimit``.

    Attributes:
        name: Name in a legend.
        source: Source of the limit.
        milliseconds: Duration of the method at the limit, inter- or extrapolated from the measured points.
        number: Position of the method among all methods of the stage.
    """

    name: str
    source: str
    milliseconds: float
    number: int


@dataclass(frozen=True)
class Diagram:
    """Error against milliseconds.

    Attributes:
        stage: Name of the stage.
        title: Displayed title of the stage.
        error_name: Name of the error.
        unit: Unit of the error.
        curves: One curve a method.
        least: Smaller errors are drawn at this value.
        missing: Trials that failed, with the reason.
        theory: Closed-form predictions, from the fastest to the slowest point.
        limits: Stability limits of methods.
    """

    stage: str
    title: str
    error_name: str
    unit: str
    curves: tuple[Curve, ...]
    least: float = 1e-9
    missing: tuple[str, ...] = ()
    theory: tuple[TheoryCurve, ...] = ()
    limits: tuple[LimitLine, ...] = ()

    @property
    def points(self) -> tuple[Point, ...]:
        """Points of all curves."""
        return tuple(point for curve in self.curves for point in curve.points)


def run_trials(stage: Stage, subject: Subject, *, progress: Progress) -> Iterator[Trial]:
    """Try every setting of a stage in turn; a failed trial is reported in its note and does not stop the others.

    The first setting is tried once in advance, because the first computation waits for memory and libraries.

    Args:
        stage: An entry of ``stages.registry``.
        subject: Object of the measurement.
        progress: Receives the current setting and the fraction done, 0 to 1; may raise to cancel.
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
    """Return the curves of ``trials`` in one of the errors of a stage, by default the first one.

    Trials without this error are left out. With a ``subject``, the diagram includes the theory.
    """
    trials = tuple(trials)
    kind = next((kind for kind in stage.errors if kind.key == error), stage.errors[0])
    found: dict[str, list[Point]] = {}
    missing = []
    for trial in trials:
        took = trial.milliseconds
        value = trial.errors.get(kind.key)
        if value is not None and math.isfinite(value) and took is not None and took > 0:
            shared = (trial.setting, trial.name, trial.note, trial.usable, trial.joined, trial.p95_ms)
            point = Point(took, value, *shared, trial.intervals.get(kind.key))
            found.setdefault(trial.setting.method, []).append(point)
        elif not trial.errors:
            missing.append(f"{method_title(trial.setting.method)}: {trial.note}")
    order = sorted(found, key=stage.methods.index)
    curves = tuple(Curve(method, tuple(found[method]), stage.methods.index(method)) for method in order)
    theory = () if subject is None else _theory_curves(stage.theory(subject, kind.key), curves)
    failed = tuple(dict.fromkeys(missing))
    limits = tuple(_limit_lines(curves, trials))
    return Diagram(stage.name, stage.title, kind.name, kind.unit, curves, kind.least, failed, theory, limits)


def _limit_lines(curves: Iterable[Curve], trials: Sequence[Trial]) -> Iterator[LimitLine]:
    """Limits of methods that have a limit and two points; the time follows a power law between points."""
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


def _theory_curves(theories: Iterable[Theory], curves: Iterable[Curve]) -> tuple[TheoryCurve, ...]:
    times = [point.milliseconds for curve in curves for point in curve.points]
    if not times:
        return ()
    along = np.geomspace(min(times), max(times), _THEORY_POINTS)
    pairs = ((one, zip(along.tolist(), one.error(along).tolist(), strict=True)) for one in theories)
    return tuple(TheoryCurve(one.name, one.source, tuple(points)) for one, points in pairs)


def pareto_front(points: Iterable[Point]) -> tuple[Point, ...]:
    """Return the usable points that no other point beats in both time and error (Pareto), sorted by time."""
    best: list[Point] = []
    for point in sorted((p for p in points if p.usable), key=lambda p: (p.milliseconds, p.error)):
        if not best or point.error < best[-1].error:
            best.append(point)
    return tuple(best)


@dataclass(frozen=True, eq=False)
class Timed(Generic[Result]):
    """An action that was executed several times.

    Attributes:
        result: Result of the run with the median time.
        seconds: (k,) durations of all runs, in order.
    """

    result: Result
    seconds: tuple[float, ...]

    @property
    def ms(self) -> float:
        """Median time [ms]; the shorter of the two middle times."""
        return 1e3 * sorted(self.seconds)[(len(self.seconds) - 1) // 2]

    @property
    def p95_ms(self) -> float:
        """95th percentile of the times [ms]."""
        return 1e3 * float(np.percentile(self.seconds, 95))


def timed(
    action: Callable[[], Result],
    *,
    repeats: int = 3,
    budget: float = math.inf,
    warm_up: bool = False,
    clock: Callable[[], float] = time.perf_counter,
) -> Timed[Result]:
    """Time ``action`` ``repeats`` times or until ``budget`` [s] is spent, after an optional untimed run."""
    if warm_up:
        action()
    results: list[Result] = []
    seconds: list[float] = []
    while len(seconds) < repeats and sum(seconds) < budget:
        start = clock()
        results.append(action())
        seconds.append(clock() - start)
    order = sorted(range(len(seconds)), key=seconds.__getitem__)
    middle = order[(len(seconds) - 1) // 2]
    return Timed(results[middle], tuple(seconds))


def trial_row(trial: Trial) -> dict[str, Cell]:
    """Return a trial as columns of a study table; its setting is part of the case."""
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
    """Return error against time: a figure for each error, a panel for each subject and a curve for each method.

    Args:
        rows: Rows of a study; points are joined in their order.
        errors: Errors, whose keys are columns.
        panel: Returns the title of the panel of a row.
        method: Returns the name of the curve of a row.
        x: Column of the time.
        x_name: Displayed name of the time.
        title: Title of a figure; braces are replaced by the name of the error.
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
    """Return the displayed name of a method."""
    return _TITLES.get(name, name.replace("-", " ").capitalize())
