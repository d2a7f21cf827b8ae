"""What is wrong with a robot's knowledge of its skin, by factor and level, made real one at a time around a nominal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

from app.contacts.estimators.names import ESTIMATORS, EstimatorName
from app.contacts.reading_settings import ReadingSettings
from app.experiments.control_setup import ControlSetup, beside_ball, place_to_press, sleeved
from app.maps.build import build_map
from app.maps.learned.as_map import learned_tactile_map
from app.maps.learned.table import LEARNED
from app.maps.methods.table import METHODS
from app.maps.tactile_map import TactileMap
from app.session.prepare import Prepared
from app.skin.misplace import Unit, misplaced
from app.touch.babbling import BabbleSpec, babble
from app.touch.sensor.effects import SensorEffects
from app.touch.sensor.noise import Noise
from app.touch.sensor.sampling import Sampling

TAXELS = {"arm": 1600, "ur5e": 2000, "icub": 500}
"""About 8 mm apart."""
RATE = 50.0
"""The nominal one [Hz]."""
TICK = 0.005
"""Of control [s], unless the skin is read more often."""
WRENCH_NOISE = 0.06
"""Of the lumped sensor [N]: what an ATI Mini45 resolves."""
TOUCHES = 4000
"""Of the babbling that maps are learned from."""


@dataclass(frozen=True)
class Knowledge:
    """What a controller knows a skin by.

    Attributes:
        rate: Readings a second [Hz].
        delay: Readings by which they come late.
        noise: Standard deviation on every taxel [Pa].
        map: How the map is made: a method, or a way to learn.
        misplaced: Error of the calibration along each axis [m].
        by: What is misplaced as one.
        estimator: From readings to force.
    """

    rate: float = RATE
    delay: int = 0
    noise: float = 0.0
    map: str = "symmetric-dirichlet"
    misplaced: float = 0.0
    by: Unit = "taxel"
    estimator: EstimatorName = "area-sum"


NOMINAL: Mapping[str, float | str] = {
    "tolerance": 3.0,
    "rate": RATE,
    "delay": 0,
    "noise": 0.0,
    "map": "symmetric-dirichlet",
    "misplaced": 0.0,
    "estimator": "area-sum",
}
"""The level of each factor while another is not: millimetres, hertz, readings, pascals, a name, millimetres, a name."""
FACTORS: Mapping[str, Sequence[float | str]] = {
    "tolerance": (1.0, 1.5, 2.0, 5.0),
    "rate": (10.0, 20.0, 100.0, 1000.0),
    "delay": (1, 2, 5),
    "noise": (100.0, 300.0, 1000.0),
    "map": ("lscm", "harmonic", "unroll", "information-distance", "self-organising"),
    "misplaced": (0.5, 1.0, 2.0, 3.0, 5.0, 7.0),
    "estimator": tuple(name for name in ESTIMATORS if name != "area-sum"),
}
"""The other levels."""


def known_by(factor: str, level: float | str, by: Unit = "taxel") -> Knowledge:
    """The nominal knowledge with one factor at a level."""
    if factor == "misplaced":
        return Knowledge(misplaced=1e-3 * float(level), by=by)
    if factor == "map":
        return Knowledge(map=str(level))
    if factor == "estimator":
        return Knowledge(estimator=next(name for name in ESTIMATORS if name == level))
    if factor == "delay":
        return Knowledge(delay=int(level))
    if factor == "noise":
        return Knowledge(noise=float(level))
    return Knowledge(rate=float(level)) if factor == "rate" else Knowledge()


def setup_of(robot: str, knowledge: Knowledge, seed: int) -> ControlSetup:
    """A robot beside its ball, known so; everything random from the seed.

    Raises:
        TactileMapsError: The robot is not installed, or the map cannot be made.

    Cost: 3 s for a robot and seed, kept; a map of its own 1 s, a learned one 5 s, kept too.
    """
    tick = min(TICK, 1.0 / knowledge.rate)
    return known(_beside(robot, tick, seed), knowledge, seed)


def known(prepared: Prepared, knowledge: Knowledge, seed: int) -> ControlSetup:
    """A prepared robot beside something that touches it, known so."""
    sensor = SensorEffects(
        noise=Noise(knowledge.noise) if knowledge.noise else None,
        sampling=Sampling(knowledge.rate, knowledge.delay / knowledge.rate),
    )
    noise = WRENCH_NOISE if knowledge.estimator == "lumped" else 0.0
    reading = ReadingSettings(estimator=knowledge.estimator, wrench_noise=noise)
    believed = believed_map(prepared, knowledge.map, knowledge.misplaced, knowledge.by, seed)
    return ControlSetup(prepared, believed, sensor, reading)


@lru_cache(maxsize=4)
def _beside(robot: str, tick: float, seed: int) -> Prepared:
    prepared = sleeved(robot, TAXELS[robot], seed)
    return beside_ball(prepared, taxel=place_to_press(prepared), tick=tick, seed=seed)


def believed_map(prepared: Prepared, map_: str, sd: float, by: Unit, seed: int) -> TactileMap | None:
    """The map that is believed; None for the true one."""
    if map_ == Knowledge.map and not sd:
        return None
    return _believed(prepared, map_, sd, by, seed)


@lru_cache(maxsize=8)
def _believed(prepared: Prepared, map_: str, sd: float, by: Unit, seed: int) -> TactileMap:
    skin = misplaced(prepared.skin, sd, seed=seed, by=by)
    if map_ in METHODS:
        return build_map(skin, method=map_)
    readings = babble(skin, BabbleSpec(touches=TOUCHES, seed=seed))
    return learned_tactile_map(skin, LEARNED[map_](readings, seed=seed))
