"""Cost in time of less accurate force feedback, by quality and delay of the force readings and by controller."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

from tactile_maps.contacts.force_estimation.estimate import ESTIMATORS
from tactile_maps.control.controllers import CONTROL_SCHEMES
from tactile_maps.studies.base.rows import Case, Row
from tactile_maps.studies.path_time.charts import factor_figures
from tactile_maps.studies.path_time.conditions import Conditions
from tactile_maps.studies.path_time.expectations import EFFECT, OF_FORCE_FEEDBACK
from tactile_maps.studies.path_time.factors import Factor, Level, chosen, sensing, varied
from tactile_maps.studies.path_time.path_time import METHOD, list_cases, measure_case
from tactile_maps.studies.path_time.replay import replay_row
from tactile_maps.studies.study.study import Study
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.sensors.sensor_effects import (
    GainSpread,
    Hysteresis,
    Noise,
    Quantisation,
    Saturation,
    SensorEffects,
    Threshold,
)


def _sensed(
    name: str, axis: str, levels: Sequence[float], effect: Callable[[float], SensorEffects], few: float, zero: float
) -> Factor:
    """A factor of the sensor whose effect is absent in nominal conditions."""
    return Factor(name, axis, levels, sensing(effect), (few,), 0.0, drawn_zero=zero)


_SECOND_FINGER = ", a finger elsewhere"


def _estimated(level: Level) -> Conditions:
    name = str(level)
    return Conditions(estimator=name.removesuffix(_SECOND_FINGER), touched=name.endswith(_SECOND_FINGER))


def _stiffness(level: Level) -> Conditions:
    cover = ElasticLayer()
    return Conditions(layer=replace(cover, modulus=float(level) * cover.modulus))


def _late(level: Level) -> Conditions:
    return Conditions(delay=int(level))


_NOMINAL = Conditions()
FACTORS: Sequence[Factor] = (
    Factor(
        "rate",
        "readings a second",
        (10.0, 20.0, 100.0, 1000.0),
        varied("rate"),
        (10.0, 1000.0),
        _NOMINAL.rate,
        note="With slow readings the time is about the theoretical one. With fast readings the lag of the posture loop "
        "of 50 ms, which the ideal servo of the theory lacks, determines the time, and a higher rate has no effect.",
    ),
    Factor(
        "delay",
        "readings late (none at 0.5)",
        (1, 2, 5),
        _late,
        (2,),
        0,
        drawn_zero=0.5,
        note="Readings without delay wait for less time than the lag of the posture loop of 50 ms, which the ideal "
        "servo of the theory lacks. With more delay the theoretical wait is longer; times below theory are then "
        "possible because controllers feed the speed of the path forward.",
    ),
    Factor(
        "noise",
        "Pa on every taxel (none at 10)",
        (100.0, 300.0, 1000.0, 3000.0),
        sensing(lambda sd: SensorEffects(noise=Noise(sd))),
        (1000.0,),
        0.0,
        drawn_zero=10.0,
        note="The theory predicts ripple from noise, not time: noise moves the centre of pressure and the measured "
        "force, and uses up tolerance that is then missing for speed.",
    ),
    _sensed(
        "threshold",
        "Pa below which nothing is felt (none at 300)",
        (1000.0, 2500.0, 5000.0),
        lambda at: SensorEffects(threshold=Threshold(at)),
        2500.0,
        300.0,
    ),
    Factor(
        "saturation",
        "Pa above which all reads the same",
        (10e3, 20e3, 40e3),
        sensing(lambda at: SensorEffects(saturation=Saturation(at))),
        (20e3,),
    ),
    _sensed(
        "quantisation",
        "Pa a step (none at 50)",
        (200.0, 1000.0, 3000.0),
        lambda step: SensorEffects(quantisation=Quantisation(step)),
        1000.0,
        50.0,
    ),
    _sensed(
        "gain spread",
        "standard deviation of the taxels' gains (none at 0.02)",
        (0.05, 0.1, 0.3),
        lambda sd: SensorEffects(gain_spread=GainSpread(sd)),
        0.1,
        0.02,
    ),
    Factor("gain error", "force read over true force", (0.7, 0.85, 1.15, 1.3), varied("gain"), (0.85,), 1.0),
    _sensed(
        "hysteresis",
        "share of the reading that creeps within 1 s (none at 0.02)",
        (0.05, 0.1, 0.3),
        lambda share: SensorEffects(hysteresis=Hysteresis(share)),
        0.1,
        0.02,
    ),
    Factor(
        "estimator",
        "how readings become a force",
        (*ESTIMATORS[1:], *(f"{name}{_SECOND_FINGER}" for name in ("area-sum", "lumped"))),
        _estimated,
        ("lumped", f"lumped{_SECOND_FINGER}"),
        ESTIMATORS[0],
    ),
    Factor(
        "stiffness",
        "of the cover, times the usual",
        (0.1, 0.3, 3.0, 10.0),
        _stiffness,
        (3.0,),
        1.0,
        note="The controller knows the stiffness of the cover and has gains for it.",
    ),
    Factor(
        "controller",
        "who leads",
        tuple(name for name in CONTROL_SCHEMES if name != _NOMINAL.controller),
        chosen("controller"),
        ("qp",),
        _NOMINAL.controller,
    ),
)


def measure(case: Case) -> list[Row]:
    """Return one row: the shortest time that meets the tolerances."""
    return measure_case(FACTORS, case)


STUDY = Study(
    "force-feedback",
    "What does it cost in time to measure the force less accurately, later or less often?",
    METHOD,
    partial(list_cases, FACTORS),
    measure,
    partial(factor_figures, FACTORS),
    OF_FORCE_FEEDBACK,
    EFFECT,
    partial(replay_row, FACTORS),
)
