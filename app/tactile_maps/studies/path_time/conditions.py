"""Conditions under which a controller follows a path: knowledge, readings and properties of the skin.

One value type serves all factors of the studies of path time, and describes the simulated robot.
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
from tactile_maps.studies.testbeds.fixed_ball import forearm_skin_scene, place_to_press, with_finger, with_fixed_ball
from tactile_maps.studies.testbeds.isomap import ISOMAP, isomap
from tactile_maps.studies.testbeds.path_following import PathSetup
from tactile_maps.studies.testbeds.slit_map import with_slits
from tactile_maps.tactile.babbling import BabbleSpec, Kind, babble
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.sensors.sensor_effects import Sampling, SensorEffects

RATE = 50.0
"""Nominal reading rate [Hz]."""
PITCH = 0.008
"""Nominal spacing of the taxels [m]."""
TICK = 0.005
"""Control period [s], unless the skin is read more often."""
WRENCH_NOISE = 0.06
"""Noise of the lumped sensor [N]: the resolution of an ATI Mini45."""
TOUCHES = 4000
"""Number of random touches from which maps are learned."""
FINGER_FORCE = 2.0
"""Force of the second finger elsewhere on the link [N]."""
_TAXELS_AT_PITCH = {"arm": 1600, "ur5e": 2000, "icub": 500}
"""Number of taxels for a spacing of ``PITCH``, by robot."""


@dataclass(frozen=True)
class Conditions:
    """Conditions of a run. The defaults are the nominal conditions.

    Attributes:
        controller: Name of the controller.
        jacobian: Source of the controller's Jacobian of the map.
        tolerance: Bound for 95 % of the errors on the body [m].
        rate: Reading rate [Hz].
        delay: Delay of the readings [readings].
        sensor: Further effects of the sensor.
        estimator: Estimator of the force.
        pixel: Pixel size of the image from which the contact centre is computed [m]; None to use the taxels.
        interpolation: Interpolation of that image.
        back_projection: Method of back-projection of a centre on the map to the body.
        map: Origin of the map: a flattening method, a learning method, or ``isomap``.
        touch: Kind of random touches from which a map is learned.
        misplaced: Calibration error along each axis [m].
        by: Unit that is misplaced as one.
        gain: Believed over true force, the same for all taxels.
        sleeve_shift: Displacement of the sleeve from its believed place along the link [m].
        sleeve_turn: Rotation of the sleeve about the link [rad].
        pitch: Spacing of the taxels [m].
        bend: Place of the contact: the share of suitable places that are flatter.
        body: Body that carries the skin: the robot's own link, or one of ``BODIES`` above that place.
        cuts: Number of cuts of the map through that place.
        layer: Cover; the controller knows its stiffness.
        touched: Whether a second finger presses the link.
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
        """Period of the readings [s]."""
        return 1.0 / self.rate

    def settings(self, settings: ControlSettings) -> ControlSettings:
        """Return ``settings`` for this controller, with theoretical gains for these readings and this cover."""
        stiffness = STIFFNESS * self.layer.foundation / ElasticLayer().foundation
        own = replace(settings, controller=self.controller, jacobian=self.jacobian)
        return tune_gains(own, self.period, self.delay, stiffness=stiffness)


def setup_of(robot: str, conditions: Conditions, seed: int) -> PathSetup:
    """Return a robot next to its ball under these conditions; the seed determines all random numbers.

    Raises:
        TactileMapsError: The robot is not installed, or the map cannot be made.

    Cost: 3 s for a robot and seed, 1 s for another map, 5 s for a learned one; all are cached.
    """
    tick = min(TICK, conditions.period)
    place = (conditions.bend, conditions.body)
    prepared = _robot_with_ball(robot, conditions.pitch, conditions.layer, place, tick, seed)
    return setup_under(_cut(prepared, conditions.cuts) if conditions.cuts else prepared, conditions, seed)


def setup_under(prepared: PreparedScene, conditions: Conditions, seed: int) -> PathSetup:
    """Return a prepared robot in contact, with the knowledge and readings of the conditions."""
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
def _robot_with_ball(
    robot: str, pitch: float, layer: ElasticLayer, place: tuple[float, str], tick: float, seed: int
) -> PreparedScene:
    taxels, (bend, body) = round(_TAXELS_AT_PITCH[robot] * (PITCH / pitch) ** 2), place
    prepared = forearm_skin_scene(robot, taxels, seed)
    taxel = place_to_press(prepared, bend=bend)
    if body in BODIES:
        prepared, taxel = with_bent_skin(prepared, taxel, BODIES[body], pitch=pitch, seed=seed)
    return with_fixed_ball(prepared, taxel=taxel, layer=layer, tick=tick, seed=seed)


@lru_cache(maxsize=4)
def _cut(prepared: PreparedScene, cuts: int) -> PreparedScene:
    return with_slits(prepared, touched_place(prepared), cuts)


def believed_map(prepared: PreparedScene, conditions: Conditions, seed: int) -> TactileMap | None:
    """Return the believed map; None for the true one."""
    nominal = Conditions()
    belief = {name: getattr(conditions, name) for name in _BELIEF}
    if all(getattr(nominal, name) == value for name, value in belief.items()):
        return None
    return _believed(prepared, replace(nominal, **belief), seed)


_BELIEF = ("map", "touch", "misplaced", "by", "gain", "sleeve_shift", "sleeve_turn")
"""Conditions that affect the believed map."""


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
