"""A small plug-in of each kind."""

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from tactile_maps.contacts.force_estimation.estimate import AreaSum, ContactReading, ForceEstimate
from tactile_maps.contacts.force_estimation.estimation import EstimatorEntry
from tactile_maps.control.controller_registry import ControllerEntry, build_by_scheme
from tactile_maps.control.motion.command import ControlSettings, JointCommand
from tactile_maps.control.motion.joint_impedance import joint_impedance
from tactile_maps.control.motion.map_kinematics import MapKinematics
from tactile_maps.control.motion.observation import Observation
from tactile_maps.control.task_control.schemes import HybridScheme
from tactile_maps.core.errors import SkinError
from tactile_maps.core.progress import Progress
from tactile_maps.export.export import ExportFormat, ExportOptions
from tactile_maps.flattening.initial_map import Disk
from tactile_maps.flattening.methods import Method
from tactile_maps.live.readings.readings import Reading, Unit
from tactile_maps.live.sources.open import SourceKind, SourceOptions
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.model.robot import Robot
from tactile_maps.skin.formats.taxel_files import TaxelFormat
from tactile_maps.skin.model.skin import Skin
from tactile_maps.skin.model.taxel_set import TaxelSet
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.mechanics.loads import Load
from tactile_maps.tactile.models.contact_model import ContactModelEntry
from tactile_maps.tactile.sensors.sensor_chain import SensorStageEntry, StageOption
from tactile_maps.tactile.sensors.sensor_effects import Readout, SensorEffects


class TwoTaxels:
    """Half of the force on each of the two nearest taxels."""

    notes = ()

    def __init__(self, skin: Skin) -> None:
        self._skin = skin
        self._positions = skin.positions

    def pressures(self, loads: Sequence[Load]) -> np.ndarray:
        """(taxels,) [Pa]."""
        found = np.zeros(len(self._skin))
        for load in loads:
            away = np.linalg.norm(self._positions - load.point, axis=1)
            elsewhere = np.array([patch.link != load.link for patch in self._skin.patches])
            away[elsewhere[self._skin.patch_of]] = np.inf
            nearest = np.argsort(away)[:2]
            found[nearest] += 0.5 * load.force / self._skin.areas[nearest]
        return found


def build_two_taxels(skin: Skin, layer: ElasticLayer, sensor: SensorEffects) -> TwoTaxels:
    """For a skin."""
    return TwoTaxels(skin)


def oblong(disk: Disk, lengths: float) -> Iterator[np.ndarray]:
    """Tutte's map on an ellipse with the proportions of the patch, along its axes of the initial map."""
    size = np.linalg.svd(disk.positions - disk.positions.mean(axis=0), compute_uv=False)
    yield disk.start * np.array([1.0, max(size[1] / size[0], 0.2)])


class Hum:
    """Mains hum: the same sine on every taxel."""

    def __init__(self, readout: Readout, pressure: float, hertz: float) -> None:
        self._pressure = pressure
        self._step = math.tau * hertz * readout.tick
        self._readings = 0

    def read(self, pressures: np.ndarray) -> np.ndarray:
        """(taxels,) [Pa]."""
        self._readings += 1
        return pressures + self._pressure * math.sin(self._step * self._readings)

    def reset(self) -> None:
        """Back to before the first reading."""
        self._readings = 0

    def state(self) -> np.ndarray:
        """(1,) how many readings there were."""
        return np.array([float(self._readings)])


def build_hum(readout: Readout, options: Mapping[str, float]) -> Hum:
    """For a skin, with the scene's numbers."""
    return Hum(readout, options["pressure"], options["hertz"])


class Slack:
    """Holds nothing: its joints are damped, as if each were led through honey."""

    why_limited = ()
    report = None

    def __init__(self, robot: Robot) -> None:
        self.rest = robot.home
        self._damping = joint_impedance(Configuration(robot).inertia(), robot.home, frequency=4.0, damping_ratio=1.0)

    def use(self, map_kinematics: MapKinematics) -> None:
        """It sees no map."""

    def reset(self) -> None:
        """The controller has no state."""

    def start(self, posture: np.ndarray, torque: np.ndarray) -> None:
        """Nor is what another controller did."""

    def command(self, settings: ControlSettings, observation: Observation) -> JointCommand:
        """Damping alone, scaled as the slider says."""
        none = np.zeros_like(observation.posture)
        return JointCommand(observation.posture, none, settings.damping_ratio * self._damping.damping, none)


class Gentle(HybridScheme):
    """Hybrid control with half of the force gain."""

    def levels(self, settings, contacts, arm, limits):
        """Return the force levels of the contacts, at half the gain."""
        return super().levels(replace(settings, force_gain=0.5 * settings.force_gain), contacts, arm, limits)


class CalibratedSum:
    """Pressure times area, times a factor from a calibration with weights."""

    FACTOR = 1.1

    def __init__(self, skin: Skin) -> None:
        self._sum = AreaSum(skin)

    def estimate(self, reading: ContactReading) -> ForceEstimate:
        """The contact's force."""
        found = self._sum.estimate(reading)
        return replace(found, force=self.FACTOR * found.force, forces=self.FACTOR * found.forces)


def read_xyz(path: Path) -> tuple[TaxelSet, ...]:
    """A line a taxel: x y z [mm]."""
    try:
        rows = np.loadtxt(path, ndmin=2)
    except ValueError as error:
        raise SkinError("this is no table of numbers", file=path, value=error, remedy="Write x y z a line") from error
    return (TaxelSet(path.stem, None, np.arange(len(rows)), 1e-3 * rows),)


def is_comb(document: object) -> bool:
    """Whether it has the places of the teeth."""
    return isinstance(document, dict) and "comb_mm" in document


def read_comb(path: Path) -> tuple[TaxelSet, ...]:
    """Teeth along x."""
    x = np.array(json.loads(path.read_text())["comb_mm"])
    return (TaxelSet(path.stem, None, np.arange(len(x)), 1e-3 * x[:, None] * [1.0, 0.0, 0.0]),)


def write_peaks(player: RecordingPlayer, path: Path, options: ExportOptions, progress: Progress) -> None:
    """A line a frame: time [s] and highest pressure [Pa]."""
    with path.open("w", encoding="utf8") as file:
        for number in range(len(player)):
            frame = player.frame(number)
            file.write(f"{frame.time:.6f} {frame.pressures.max(initial=0.0):.6g}\n")
            progress("Peaks", (number + 1) / len(player))


class Sine:
    """Ten readings of so many taxels as the address says, that swell and fade."""

    finite = True
    slow = False

    def __init__(self, address: str) -> None:
        self.address = address
        self._taxels = int(address.partition(":")[2])
        self._tick = 0

    def open(self) -> None:
        """Start at the first reading."""
        self._tick = 0

    def receive(self, timeout: float) -> Reading | None:
        """The next."""
        from tactile_maps.live.readings.readings import SourceEndedError

        if self._tick == 10:
            raise SourceEndedError("the sine is over")
        self._tick += 1
        return Reading(0.1 * self._tick, np.full(self._taxels, 1e3 * abs(math.sin(self._tick))), Unit.PASCAL)

    def close(self) -> None:
        """The source holds no resources."""


def build_sine(address: str, options: SourceOptions) -> Sine:
    """The source at ``sine:TAXELS``."""
    return Sine(address)


def hum_noise(options: Mapping[str, float]) -> float:
    """Standard deviation of a sine with this amplitude [Pa]."""
    return options["pressure"] / math.sqrt(2)


TWO_TAXELS = ContactModelEntry("two-taxels", "Two taxels", "Half of the force on each.", build_two_taxels)
OBLONG = Method("oblong", "the proportions of the patch", oblong)
HUM = SensorStageEntry(
    "hum",
    "Mains hum",
    "The same sine on every taxel",
    build_hum,
    (StageOption("pressure", 50.0, 0.0, 1e4), StageOption("hertz", 50.0, 0.1, 1e3)),
    before="noise",
    noise=hum_noise,
)
SLACK = ControllerEntry(
    "slack",
    "Slack",
    "Damps its joints and holds nothing",
    lambda robot, task_manager, map_kinematics: Slack(robot),
    ("damping_ratio",),
)
GENTLE = ControllerEntry(
    "gentle",
    "Gentle",
    "Hybrid control with half of the force gain",
    build_by_scheme(Gentle),
    ("force_gain", "integral_time"),
    has_task=True,
)
CALIBRATED_SUM = EstimatorEntry(
    "calibrated-sum", "Calibrated sum", "Pressure times area times 1.1.", lambda skin, depth: CalibratedSum(skin)
)
XYZ = TaxelFormat("xyz", "Points in millimetres", (".xyz",), read_xyz)
COMB = TaxelFormat("comb", "Taxels on a line", (".json",), read_comb, is_comb)
PEAKS = ExportFormat("peaks", "Highest pressures", ".peaks", write_peaks)
SINE = SourceKind("sine", "Swelling and fading", build_sine)
