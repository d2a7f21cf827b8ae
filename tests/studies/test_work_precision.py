"""Work-precision diagrams: curves from trials, what cannot be drawn stays out, and the best for the time."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tactile_maps.core.errors import MapError
from tactile_maps.studies.study.work_precision import (
    ErrorKind,
    Point,
    Setting,
    Stage,
    Subject,
    Theory,
    Trial,
    diagram,
    pareto_front,
    run_trials,
    timed,
    work_precision_figures,
)

OFF = ErrorKind("off", "Off", "%", "How far off.", 0.01)
SLOW = ErrorKind("late", "Late", "mm", "How late.", 0.01)


NO_SUBJECT = Subject(None, (), (), ())


def stage(trials=lambda subject, setting: [], settings=()):
    return Stage(
        "guess",
        "Guess",
        "Which?",
        ("first", "second", "third"),
        (OFF, SLOW),
        lambda _: settings,
        trials,
        lambda _: "",
        lambda _: 1.0,
        "There is no interval.",
    )


def trial(method, milliseconds, off, **more):
    return Trial(Setting("guess", method, {"at": milliseconds}), "", milliseconds, {"off": off}, **more)


def point(milliseconds, error, *, usable=True):
    return Point(milliseconds, error, Setting("guess", "first", {"at": milliseconds}), usable=usable)


def test_each_method_has_a_curve_in_stage_order_with_points_in_order_of_arrival():
    made = diagram(stage(), [trial("third", 5, 1), trial("first", 9, 3), trial("first", 2, 4)])
    assert [(curve.method, curve.number) for curve in made.curves] == [("first", 0), ("third", 2)]
    assert [(p.milliseconds, p.error) for p in made.curves[0].points] == [(9, 3), (2, 4)]
    assert (made.stage, made.title, made.error_name, made.unit, made.least) == ("guess", "Guess", "Off", "%", 0.01)
    assert len(made.points) == 3


def test_theory_is_drawn_along_the_points_of_a_subject():
    halved = Theory("half", "1 / t", lambda ms: 1 / ms)
    with_theory = replace(stage(), theory=lambda _subject, key: [halved] if key == "off" else [])
    trials = [trial("first", 2, 4), trial("first", 8, 3)]
    (curve,) = diagram(with_theory, trials, subject=NO_SUBJECT).theory
    assert (curve.name, curve.source) == ("half", "1 / t")
    assert [curve.points[0], curve.points[-1]] == [pytest.approx((2, 0.5)), pytest.approx((8, 0.125))]
    assert diagram(with_theory, trials).theory == ()
    assert diagram(with_theory, [], subject=NO_SUBJECT).theory == ()


def test_only_points_with_the_chosen_error_are_drawn():
    both = Trial(Setting("guess", "second"), "", 3, {"off": 1, "late": 7}, intervals={"off": (0.5, 2), "late": (6, 8)})
    made = diagram(stage(), [both, trial("first", 2, 4)], error="late")
    assert [(p.error, p.interval, made.unit) for p in made.points] == [(7, (6, 8), "mm")]
    assert made.missing == ()


def test_undrawable_points_are_omitted_and_failures_named():
    failed = Trial(Setting("guess", "second"), "", None, {}, note="it does not open", usable=False)
    bad = [trial("first", 2, None), trial("first", 2, float("inf")), trial("first", 0, 1), failed, failed]
    made = diagram(stage(), [*bad, trial("first", 2, 0.0)])
    assert [p.error for p in made.points] == [0.0], "an error of zero is one"
    assert made.missing == ("Second: it does not open",)


def test_best_settings_are_not_dominated():
    points = [
        point(5, 2),
        point(1, 9),
        point(3, 9),
        point(2, 4),
        point(9, 2),
        point(4, 3.9),
        point(0.1, 0.1, usable=False),
    ]
    best = pareto_front(points)
    assert [(p.milliseconds, p.error) for p in best] == [(1, 9), (2, 4), (4, 3.9), (5, 2)]
    for p in points:
        assert not p.usable or p in best or any(q.milliseconds <= p.milliseconds and q.error <= p.error for q in best)
    assert pareto_front([]) == ()


def test_every_setting_is_tried_even_if_another_one_fails():
    requested = [Setting("guess", name) for name in ("first", "second", "third")]
    done = []
    reports = []

    def trials(subject, setting):
        done.append(setting.method)
        if setting.method == "second":
            raise MapError("it does not open")
        return [Trial(setting, "", 1.0, {"off": 1.0})]

    found = list(run_trials(stage(trials, requested), NO_SUBJECT, progress=lambda *how: reports.append(how)))
    assert done == ["first", "first", "second", "third"], "the first once more, to warm up"
    assert [t.setting for t in found] == requested
    assert [t.usable for t in found] == [True, False, True]
    assert "does not open" in found[1].note
    assert [share for _, share in reports] == [0, 0, 1 / 3, 2 / 3]


@pytest.mark.parametrize(
    ("lasting", "result"), [([5.0], (0, 5.0)), ([0.1, 9.0], (0, 0.1)), ([0.02, 0.01, 0.05], (0, 0.02))]
)
def test_median_of_the_runs_within_the_budget_is_used(lasting, result):
    ticks = []
    count = iter(range(9))
    now = 0.0
    for seconds in lasting:
        ticks += [now, now + seconds]
        now += seconds
    clock = iter(ticks)
    made = timed(lambda: next(count), clock=lambda: next(clock), budget=0.2)
    assert (made.result, made.ms) == (result[0], pytest.approx(1e3 * result[1]))
    assert made.seconds == pytest.approx(lasting)
    assert next(clock, None) is None, "it ran as often as it should"


def test_rows_become_a_figure_for_each_error_with_a_panel_for_each_subject():
    rows = [{"method": m, "body": b, "ms": 1.0, "off": 2.0, "late": 3.0} for b in "xy" for m in ("first", "second")]
    made = work_precision_figures(rows, (OFF, SLOW), panel=lambda row: row["body"], title="{} of all")
    assert [(figure.title, figure.x, figure.y, figure.least) for figure in made] == [
        ("Off of all", "milliseconds", "%", 0.01),
        ("Late of all", "milliseconds", "mm", 0.01),
    ]
    for figure, value in zip(made, (2.0, 3.0), strict=True):
        assert [panel.title for panel in figure.panels] == ["x", "y"]
        assert figure.panels[0].curves == {"first": [(1.0, value)], "second": [(1.0, value)]}
