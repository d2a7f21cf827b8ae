"""The simulated skin in the posture of a measured frame, and by how much the measured one reads more."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactile_maps.core.arrays import FloatArray, freeze_arrays
from tactile_maps.core.errors import LiveError
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.scene.effects import Effects
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.simulation.simulation import Simulation


@dataclass(frozen=True, eq=False)
class SkinDifference:
    """What a measured skin reads beside a simulated one.

    Attributes:
        measured: (taxels,) [Pa].
        simulated: (taxels,) [Pa].
    """

    measured: FloatArray
    simulated: FloatArray

    def __post_init__(self) -> None:
        freeze_arrays(self, "measured", "simulated")

    @property
    def difference(self) -> FloatArray:
        """(taxels,) measured minus simulated [Pa]."""
        return self.measured - self.simulated

    @property
    def largest(self) -> float:
        """The largest difference by amount [Pa]; 0 without taxels."""
        return float(np.abs(self.difference).max(initial=0.0))

    @property
    def rms(self) -> float:
        """Root of the mean squared difference over all taxels [Pa]; 0 without taxels."""
        return float(np.sqrt(np.square(self.difference).sum() / max(len(self.measured), 1)))


class SimulatedSkin:
    """What the skin should read in a posture, of the robot itself and the scene's objects. Mutable; one thread's own.

    The robot is put into each posture and nothing moves, so objects stay where the scene has them at its start. The
    pressures are those of the elastic foundation, whose forces follow from how deep shapes are in the layer alone: of
    a posture without motion the other models know no force. The sensor is ideal.

    Args:
        prepared: The scene with its objects, from ``prepare`` (``prepare_measured`` leaves the objects out).

    Raises:
        RobotError: MuJoCo refuses the model.
        MeshError: A mesh object is no solid.
    """

    def __init__(self, prepared: PreparedScene) -> None:
        self._simulation = Simulation(
            prepared.robot,
            prepared.skin,
            Effects(skin="foundation", contact="all", fingers=False),
            objects=prepared.objects,
            layer=prepared.scene.layer,
        )

    def pressures(self, posture: FloatArray) -> FloatArray:
        """(taxels,) [Pa] in ``posture`` (joints,) [rad, or m].

        Raises:
            LiveError: It is not one finite position for each joint.
        """
        joints = len(self._simulation.posture)
        if posture.shape != (joints,) or not np.isfinite(posture).all():
            raise LiveError("this is no posture of the robot", value=posture, remedy=f"Give {joints} finite positions")
        self._simulation.place(posture)
        return self._simulation.sense()

    def compare(self, frame: Frame) -> SkinDifference:
        """A measured frame beside the simulated skin in its posture; errors as ``skin_difference``."""
        check_comparable(frame)
        return skin_difference(frame, self.pressures(frame.posture))


def check_comparable(frame: Frame) -> None:
    """Refuse a measured frame whose readings a simulation cannot be compared with.

    Raises:
        LiveError: It has no pressures above those of the untouched skin.
    """
    if frame.units is not ReadingUnits.CALIBRATED:
        remedy = "Calibrate the skin and show it in kPa"
        raise LiveError("readings without a calibration have no unit to compare", value=frame.units.unit, remedy=remedy)


def skin_difference(frame: Frame, simulated: FloatArray) -> SkinDifference:
    """A measured frame beside what was simulated (taxels,) [Pa] in its posture.

    Raises:
        LiveError: As ``check_comparable``, or it is of another skin.
    """
    check_comparable(frame)
    if frame.pressures.shape != simulated.shape:
        found = f"{len(frame.pressures)} taxels for {len(simulated)}"
        raise LiveError("the readings are of another skin than the simulation's", value=found)
    return SkinDifference(frame.pressures, simulated)
