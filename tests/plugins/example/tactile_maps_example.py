"""One small plug-in of each kind."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from app.contacts.centre_of_pressure import taxel_positions
from app.contacts.force_estimation.estimate import AreaSum, ContactReading, ForceEstimate
from app.contacts.force_estimation.estimation import EstimatorEntry
from app.core.errors import SkinError
from app.core.progress import Progress
from app.export.export import ExportFormat, ExportOptions
from app.flattening.initial_map import Disk
from app.flattening.methods import Method
from app.live.readings import Reading, Unit
from app.live.sources.open import SourceKind, SourceOptions
from app.recording.player import RecordingPlayer
from app.skin.formats.taxel_files import TaxelFormat
from app.skin.formats.taxel_set import TaxelSet
from app.skin.skin import Skin
from app.tactile.elastic_layer import ElasticLayer
from app.tactile.loads import Load
from app.tactile.models.contact_model import ContactModelEntry
from app.tactile.sensor_effects import SensorEffects


class TwoTaxels:
    """Half of the force on each of the two nearest taxels."""

    notes = ()

    def __init__(self, skin: Skin) -> None:
        self._skin, self._positions = skin, taxel_positions(skin)

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


def write_peaks(player: RecordingPlayer, path: Path, options: ExportOptions, progress: Progress) -> None:
    """A line a frame: time [s] and highest pressure [Pa]."""
    with path.open("w", encoding="utf8") as file:
        for number in range(len(player)):
            frame = player.frame(number)
            file.write(f"{frame.time:.6f} {frame.pressures.max(initial=0.0):.6g}\n")
            progress("Peaks", (number + 1) / len(player))


class Sine:
    """Ten readings of so many taxels as the address says, that swell and fade."""

    finite, slow = True, False

    def __init__(self, address: str) -> None:
        self.address, self._taxels, self._tick = address, int(address.partition(":")[2]), 0

    def open(self) -> None:
        """From the first reading."""
        self._tick = 0

    def receive(self, timeout: float) -> Reading | None:
        """The next."""
        from app.live.readings import SourceEndedError

        if self._tick == 10:
            raise SourceEndedError("the sine is over")
        self._tick += 1
        return Reading(0.1 * self._tick, np.full(self._taxels, 1e3 * abs(math.sin(self._tick))), Unit.PASCAL)

    def close(self) -> None:
        """Nothing to let go of."""


def build_sine(address: str, options: SourceOptions) -> Sine:
    """The source at ``sine:TAXELS``."""
    return Sine(address)


TWO_TAXELS = ContactModelEntry("two-taxels", "Two taxels", "Half of the force on each.", build_two_taxels)
OBLONG = Method("oblong", "the proportions of the patch", oblong)
CALIBRATED_SUM = EstimatorEntry(
    "calibrated-sum", "Calibrated sum", "Pressure times area times 1.1.", lambda skin, depth: CalibratedSum(skin)
)
XYZ = TaxelFormat("xyz", "Points in millimetres", (".xyz",), read_xyz)
PEAKS = ExportFormat("peaks", "Highest pressures", ".peaks", write_peaks)
SINE = SourceKind("sine", "Swelling and fading", build_sine)
