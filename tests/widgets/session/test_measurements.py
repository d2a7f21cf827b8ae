"""Results that come after another scene is shown: each knows the scene it was asked for, and is dropped."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tactile_maps.editing.arrange import scale
from tactile_maps.editing.document import MapDocument
from tactile_maps.scene.scene import with_override
from tactile_maps.simulation.known_load_check import WeighingResult
from tactile_maps.studies.ablation import ablation_cost
from tactile_widgets.session.backends import INLINE
from tactile_widgets.session.live_session import LiveSession
from tactile_widgets.workers.cost_worker import InlineCostWorker
from tactile_widgets.workers.map_quality_worker import InlineMapQualityWorker


class HeldCosts(InlineCostWorker):
    """Weighs when it is let go."""

    def weigh(self, *asked):
        self.held = asked

    def let_go(self):
        super().weigh(*self.held)


class HeldMaps(InlineMapQualityWorker):
    """Compares when it is let go."""

    def compare(self, *asked):
        self.held = asked

    def let_go(self):
        super().compare(*self.held)


@pytest.fixture(scope="module")
def prepared(coarse_prepared):
    """It is measured: twice in each test."""
    return coarse_prepared


@pytest.fixture
def live(qtbot, prepared):
    made = LiveSession(backends=replace(INLINE, cost_worker=HeldCosts, map_quality_worker=HeldMaps))
    made.show_prepared(prepared)
    yield made
    made.close()
    made.deleteLater()


@pytest.fixture
def told(live):
    """Every fact of the measurements, by name."""
    heard = []
    facts = live.measurements
    for name in ("measured", "compared", "map_failed", "priced", "weighed", "cost_failed", "weighing_changed"):
        getattr(facts, name).connect(lambda value, name=name: heard.append((name, value)))
    return heard


def ask(live, prepared):
    """Everything that can be asked."""
    larger = scale(MapDocument.of(prepared.map), [0], 2.0).map
    live.measurements.measure(prepared.map)
    live.measurements.compare(prepared.map, larger)
    live.measurements.price(prepared, prepared.scene.effects)
    live.measurements.weigh(prepared, prepared.scene.effects)


def answer(live):
    """All of it comes."""
    live.measurements.map_quality_worker.run()
    live.measurements.map_quality_worker.let_go()
    live.measurements.cost_worker.run()
    live.measurements.cost_worker.let_go()


def test_results_of_the_scene_that_is_shown_are_told(live, told, prepared):
    ask(live, prepared)
    assert live.measurements.weighing
    answer(live)
    assert not live.measurements.weighing
    values = dict(told)
    assert [name for name, _ in told] == [
        "weighing_changed", "measured", "compared", "priced", "weighing_changed", "weighed",
    ]  # fmt: skip
    assert isinstance(values["weighed"], WeighingResult)
    assert values["priced"].keys() == ablation_cost(prepared, effects=prepared.scene.effects, seconds=0.05).keys()


def test_late_results_of_the_scene_before_are_dropped(live, told, prepared):
    ask(live, prepared)
    live.show_prepared(prepared)  # the same again, from its start: nobody waits for what was asked before
    assert told == [("weighing_changed", True), ("weighing_changed", False)]
    answer(live)
    assert told[2:] == []


def test_a_late_failure_of_the_scene_before_is_not_told(live, told, prepared):
    failures = []
    worker = live.measurements.cost_worker
    live.failed.connect(failures.append)
    live.measurements.weigh(prepared, with_override(prepared.scene, "skin", "off").effects)
    late = worker.held
    live.show_prepared(prepared)
    live.measurements.weigh(prepared, prepared.scene.effects)
    newest = worker.held
    worker.held = late
    worker.let_go()
    assert failures == []
    assert live.measurements.weighing, "the load of now is still there"
    worker.held = newest
    worker.let_go()
    assert told[-1][0] == "weighed"
