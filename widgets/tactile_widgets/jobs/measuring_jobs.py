"""Functions that measure in the background: maps, effects, stages, and finer simulations of a session."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.flattening.chart import Chart
from tactile_maps.live.simulated_skin import SimulatedSkin
from tactile_maps.maps.evaluation.comparison import Comparison, TaxelLayout, compare_maps
from tactile_maps.maps.evaluation.quality import MapQuality, measure
from tactile_maps.maps.evaluation.topography import BodyDistances
from tactile_maps.maps.model.layout import MapLayout, Placement
from tactile_maps.maps.model.tactile_image import TactileImage
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.scene.effects import Effects
from tactile_maps.session.frame import Frame
from tactile_maps.session.input_log import TimedInput
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.reference_run import ReferenceDifference, ReferenceRun
from tactile_maps.simulation.known_load_check import WeighingResult, weigh
from tactile_maps.skin.model.skin import Skin
from tactile_maps.studies.ablation import ablation_cost
from tactile_maps.studies.budget.measurement import BudgetMeasurement, measure_for_budget
from tactile_maps.studies.study.work_precision import Subject, Trial, run_trials
from tactile_widgets.jobs.executor import Kept, Report

KNOWN_MASS = 0.1
"""Mass of the known load [kg]."""
_PIXELS = 512
"""Pixels along the longer side of the map when it is first measured; the default of ``measure``."""
_REPORT_EVERY = 0.2
"""Wall time between reports of a reference run [s]."""


class SkinMeasurements:
    """Measures maps of one skin, and keeps what does not change. Mutable: charts are replaced as they are edited.

    Distances on the body are computed once. A new chart changes only its own image, unless the size of the map changes:
    pixels are a fixed share of it, so that the result does not depend on the maps that were measured before.
    """

    def __init__(self, skin: Skin) -> None:
        self.skin = skin
        self.distances = BodyDistances(skin)
        self._charts: dict[int, Chart] = {}
        self._images: dict[int, TactileImage] = {}
        self._resolution = 0.0

    def quality(self, charts: Mapping[int, Chart], layout: MapLayout) -> MapQuality:
        """Return the quality of the map with these charts; charts of other patches are those of the previous call."""
        self._charts |= charts
        map_ = TactileMap(self.skin, tuple(self._charts[k] for k in range(len(self._charts))), layout)
        resolution = max(float(np.ptp(map_.bounds, axis=0).max()) / _PIXELS, 1e-9)
        outdated = charts if resolution == self._resolution else self._charts
        self._resolution = resolution
        for number, chart in outdated.items():
            alone = TactileMap(Skin((self.skin.patches[number],)), (chart,), MapLayout((Placement(),)))
            self._images[number] = TactileImage(alone, resolution=resolution)
        return measure(map_, distances=self.distances, images=[self._images[k] for k in range(len(self._charts))])


def measure_map(
    skin: Kept[SkinMeasurements], charts: Mapping[int, Chart], layout: MapLayout, _report: Report
) -> MapQuality:
    """Return the quality of a map.

    Cost: 1 to 3 s for the first map of a skin; then 40 ms, and 30 ms for each new chart, or for all if the map's size
    changes.
    """
    return skin.value.quality(charts, layout)


def compare_two_maps(
    skin: Kept[SkinMeasurements] | None,
    first: TactileMap | TaxelLayout,
    second: TactileMap | TaxelLayout,
    _report: Report,
) -> Comparison:
    """Compare two maps of one skin, with its distances if they are known."""
    return compare_maps(first, second, distances=None if skin is None else skin.value.distances)


def measure_costs(scene: Kept[PreparedScene], effects: Effects, seconds: float, _report: Report) -> dict[str, float]:
    """Return the milliseconds per tick that each effect costs, measured for about ``seconds``."""
    return dict(ablation_cost(scene.value, effects=effects, seconds=seconds))


def weigh_known_load(scene: Kept[PreparedScene], effects: Effects, _report: Report) -> WeighingResult:
    """Put the known load on the skin, and return what the skin reads. Cost: 1 to 5 s."""
    prepared = scene.value
    return weigh(prepared.robot, prepared.skin, prepared.scene.layer, effects.skin, mass=KNOWN_MASS)


def measure_stage(name: str, subject: Subject, report: Report) -> None:
    """Measure a stage of ``stages.registry`` for its work-precision diagram; send each round of trials at once."""
    from tactile_maps.studies.stages.registry import STAGES

    trials: list[Trial] = []

    def send_trials() -> None:
        if trials:
            report.part(tuple(trials))
            trials.clear()

    def progress(text: str, share: float) -> None:
        send_trials()
        report(text, share)

    for trial in run_trials(STAGES[name], subject, progress=progress):
        trials.append(trial)  # noqa: PERF402 (progress empties the list meanwhile)
    send_trials()


def measure_budget(subject: Subject, paths: bool, report: Report) -> BudgetMeasurement:
    """Measure the settings of all stages; with ``paths``, those of control too."""
    return measure_for_budget(subject, paths=paths, progress=report)


def prepare_simulated_skin(skin: Kept[SimulatedSkin], _report: Report) -> None:
    """Prepare a simulated skin. Cost: 0.5 to 10 s."""
    _ = skin.value


def simulate_pressures(skin: Kept[SimulatedSkin], posture: FloatArray, _report: Report) -> FloatArray:
    """Return the pressures of a simulated skin (taxels,) [Pa] in a posture.

    Cost: 0.2 to 1 ms; 25 ms for 4,000 taxels on a whole body.
    """
    return skin.value.pressures(posture)


def follow_session(
    run: Kept[ReferenceRun], inputs: tuple[TimedInput, ...], frame: Frame, report: Report
) -> ReferenceDifference:
    """Simulate a reference run up to a frame, and return the difference; send how far it is behind [s].

    Args:
        run: The run.
        inputs: Inputs of the session since the frame before.
        frame: A frame of the session.
        report: Receives the time that is still missing.
    """
    reference = run.value
    reference.take(inputs)
    while not reference.advance(frame.tick, _REPORT_EVERY):
        report.part(frame.time - reference.time)
    return reference.compare(frame)
