"""What a controller has to work with when it follows a path: how the skin is known, read and made. One value for all
factors of the studies of path time, and the simulated robot under those conditions.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import lru_cache

from tactile_maps.contacts.detection.image_centre import BackProjection
from tactile_maps.contacts.force_estimation.estimate import EstimatorName
from tactile_maps.contacts.pipeline import ReadingSettings
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.flattening.methods import METHODS
from tactile_maps.maps.build import build_map
from tactile_maps.maps.learned.as_tactile_map import learned_tactile_map
from tactile_maps.maps.learned.methods import LEARNING_METHODS
from tactile_maps.maps.model.jacobian import JacobianKind
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.skin.calibration_error import (
    ErrorUnit,
    with_area_error,
    with_calibration_error,
    with_sleeve_displaced,
)
from tactile_maps.studies.path_time.body_path import touched_place
from tactile_maps.studies.path_time.gains import STIFFNESS, tune_gains
from tactile_maps.studies.testbeds.bent_skin import BODIES, with_bent_skin
from tactile_maps.studies.testbeds.beside_ball import beside_ball, forearm_skin_scene, place_to_press, with_finger
from tactile_maps.studies.testbeds.isomap import ISOMAP, isomap
from tactile_maps.studies.testbeds.path_following import PathSetup
from tactile_maps.studies.testbeds.slit_map import with_slits
from tactile_maps.tactile.babbling import BabbleSpec, Kind, babble
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.sensors.sensor_effects import Sampling, SensorEffects

RATE = 50.0
"""The nominal one [Hz]."""
PITCH = 0.008
"""The nominal spacing of taxels [m]."""
TICK = 0.005
"""Of control [s], unless the skin is read more often."""
WRENCH_NOISE = 0.06
"""Of the lumped sensor [N]: what an ATI Mini45 resolves."""
TOUCHES = 4000
"""Of the babbling that maps are learned from."""
FINGER_FORCE = 2.0
"""Of somebody's finger elsewhere on the link [N]."""
_TAXELS_AT_PITCH = {"arm": 1600, "ur5e": 2000, "icub": 500}
"""That make ``PITCH``."""


@dataclass(frozen=True)
class Conditions:
    """What a controller follows a path with. The defaults are the nominal conditions.

    Attributes:
        controller: Which.
        jacobian: How it knows the way of the map over the body.
        tolerance: 95 % of the errors on the body are to be within this [m].
        rate: Readings a second [Hz].
        delay: Readings by which they come late.
        sensor: What else the sensor does to them.
        estimator: From readings to force.
        pixel: Of the image that the contact's centre is taken from [m]; None for straight from the taxels.
        interpolation: Of that image.
        back_projection: Of a centre on the map to the body.
        map: How the map is made: a method of flattening, of learning, or ``isomap``.
        touch: How the skin is touched where its map is learned.
        misplaced: Error of the calibration along each axis [m].
        by: What is misplaced as one.
        gain: What is believed of a force, over the true one: the same for all taxels.
        sleeve_shift: How far the whole sleeve sits beside where it is believed, along the link [m].
        sleeve_turn: By how much it is turned about the link [rad].
        pitch: Spacing of the taxels [m].
        bend: Where the skin is touched: the share of the places fit for it that are flatter.
        body: What bears the skin: the robot's own link, or one of ``BODIES`` over that place.
        cuts: How many cuts of the map lead through that place.
        layer: The cover; the controller is told its stiffness.
        touched: Whether somebody's finger also presses the link.
    """

    controller: str = "hybrid"
    jacobian: JacobianKind = "smoothed"
    tolerance: float = 0.003
    rate: float = RATE
    delay: int = 0
    sensor: SensorEffects = field(default_factory=SensorEffects)
    estimator: EstimatorName = "area-sum"
    pixel: float | None = None
    interpolation: str = "barycentric"
    back_projection: BackProjection = "triangle"
    map: str = "symmetric-dirichlet"
    touch: Kind = "unbiased"
    misplaced: float = 0.0
    by: ErrorUnit = "taxel"
    gain: float = 1.0
    sleeve_shift: float = 0.0
    sleeve_turn: float = 0.0
    pitch: float = PITCH
    bend: float = 0.0
    body: str = "own link"
    cuts: int = 0
    layer: ElasticLayer = field(default_factory=ElasticLayer)
    touched: bool = False

    @property
    def period(self) -> float:
        """From one reading to the next [s]."""
        return 1.0 / self.rate

    def settings(self, settings: ControlSettings) -> ControlSettings:
        """``settings`` for this controller, with gains by theory for these readings and this cover."""
        stiffness = STIFFNESS * self.layer.foundation / ElasticLayer().foundation
        own = replace(settings, controller=self.controller, jacobian=self.jacobian)
        return tune_gains(own, self.period, self.delay, stiffness=stiffness)


def setup_of(robot: str, conditions: Conditions, seed: int) -> PathSetup:
    """A robot beside its ball, under these conditions; everything random from the seed.

    Raises:
        TactileMapsError: The robot is not installed, or the map cannot be made.

    Cost: 3 s for a robot and seed, kept; a map of its own 1 s, a learned one 5 s, kept too.
    """
    tick = min(TICK, conditions.period)
    at = (conditions.bend, conditions.body)
    prepared = _robot_beside_ball(robot, conditions.pitch, conditions.layer, at, tick, seed)
    return setup_under(_cut(prepared, conditions.cuts) if conditions.cuts else prepared, conditions, seed)


def setup_under(prepared: PreparedScene, conditions: Conditions, seed: int) -> PathSetup:
    """A prepared robot beside something that touches it, known and read so."""
    sampling = Sampling(conditions.rate, conditions.delay / conditions.rate)
    noise = WRENCH_NOISE if conditions.estimator == "lumped" else 0.0
    return PathSetup(
        with_finger(prepared, FINGER_FORCE) if conditions.touched else prepared,
        believed_map(prepared, conditions, seed),
        replace(conditions.sensor, sampling=sampling),
        ReadingSettings(
            conditions.estimator,
            wrench_noise=noise,
            pixel=conditions.pixel,
            interpolation=conditions.interpolation,
            back_projection=conditions.back_projection,
        ),
        pressed_elsewhere=FINGER_FORCE if conditions.touched else 0.0,
    )


@lru_cache(maxsize=4)
def _robot_beside_ball(
    robot: str, pitch: float, layer: ElasticLayer, at: tuple[float, str], tick: float, seed: int
) -> PreparedScene:
    taxels, (bend, body) = round(_TAXELS_AT_PITCH[robot] * (PITCH / pitch) ** 2), at
    prepared = forearm_skin_scene(robot, taxels, seed)
    taxel = place_to_press(prepared, bend=bend)
    if body in BODIES:
        prepared, taxel = with_bent_skin(prepared, taxel, BODIES[body], pitch=pitch, seed=seed)
    return beside_ball(prepared, taxel=taxel, layer=layer, tick=tick, seed=seed)


@lru_cache(maxsize=4)
def _cut(prepared: PreparedScene, cuts: int) -> PreparedScene:
    return with_slits(prepared, touched_place(prepared), cuts)


def believed_map(prepared: PreparedScene, conditions: Conditions, seed: int) -> TactileMap | None:
    """The map that is believed; None for the true one."""
    nominal = Conditions()
    belief = {name: getattr(conditions, name) for name in _BELIEF}
    if all(getattr(nominal, name) == value for name, value in belief.items()):
        return None
    return _believed(prepared, replace(nominal, **belief), seed)


_BELIEF = ("map", "touch", "misplaced", "by", "gain", "sleeve_shift", "sleeve_turn")
"""What of the conditions the believed map is made by."""


@lru_cache(maxsize=8)
def _believed(prepared: PreparedScene, belief: Conditions, seed: int) -> TactileMap:
    skin = with_calibration_error(prepared.skin, belief.misplaced, seed=seed, by=belief.by)
    skin = with_area_error(skin, belief.gain) if belief.gain != 1.0 else skin
    if belief.sleeve_shift or belief.sleeve_turn:
        skin = with_sleeve_displaced(skin, shift=belief.sleeve_shift, turn=belief.sleeve_turn)
    if belief.map in METHODS:
        return build_map(skin, method=belief.map)
    if belief.map == ISOMAP:
        return learned_tactile_map(skin, isomap(prepared.map))
    readings = babble(skin, BabbleSpec(kind=belief.touch, touches=TOUCHES, seed=seed))
    return learned_tactile_map(skin, LEARNING_METHODS[belief.map](readings, seed=seed))
