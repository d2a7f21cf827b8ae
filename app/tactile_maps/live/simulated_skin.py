"""Pressures simulated in the posture of a measured frame, and their difference from the measured ones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactile_maps.core.arrays import ArrayFields, FloatArray
from tactile_maps.core.errors import LiveError
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.scene.effects import Effects
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.simulation.simulation import Simulation


@dataclass(frozen=True, eq=False)
class SkinDifference(ArrayFields):
    """Measured and simulated pressures of a skin in the same posture.

    Attributes:
        measured: (taxels,) measured pressures [Pa].
        simulated: (taxels,) simulated pressures [Pa].
    """

    measured: FloatArray
    simulated: FloatArray

    @property
    def difference(self) -> FloatArray:
        """(taxels,) measured minus simulated pressures [Pa]."""
        return self.measured - self.simulated

    @property
    def largest(self) -> float:
        """Largest absolute difference [Pa]; 0 without taxels."""
        return float(np.abs(self.difference).max(initial=0.0))

    @property
    def rms(self) -> float:
        """Root mean square difference over all taxels [Pa]; 0 without taxels."""
        return float(np.sqrt(np.square(self.difference).sum() / max(len(self.measured), 1)))


class SimulatedSkin:
    """Simulated pressures from self-contact and the scene's objects, by posture. Mutable; for one thread.

    The robot is placed in each posture without motion, so objects stay in their initial poses. The pressures are those
    of the elastic foundation, which depend only on the depth of shapes in the cover; the other models have no force in
    a posture without motion. The sensor is ideal.

    Args:
        prepared: The scene with its objects, from ``prepare`` (``prepare_measured`` leaves the objects out).

    Raises:
        RobotError: MuJoCo rejects the model.
        MeshError: The mesh of an object is not a closed solid.
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
        """Return the pressures (taxels,) [Pa] in ``posture`` (joints,) [rad, or m for slides].

        Raises:
            LiveError: The posture is not one finite position for each joint.
        """
        joints = len(self._simulation.posture)
        if posture.shape != (joints,) or not np.isfinite(posture).all():
            raise LiveError("invalid posture", value=posture, remedy=f"Give {joints} finite positions")
        self._simulation.place(posture)
        return self._simulation.sense()


def check_comparable(frame: Frame) -> None:
    """Check that a measured frame can be compared with a simulation.

    Raises:
        LiveError: The frame has no calibrated pressures above the untouched skin.
    """
    if frame.units is not ReadingUnits.CALIBRATED:
        remedy = "Calibrate the skin and show it in kPa"
        problem = "readings without a calibration cannot be compared with a simulation"
        raise LiveError(problem, value=frame.units.unit, remedy=remedy)


def skin_difference(frame: Frame, simulated: FloatArray) -> SkinDifference:
    """Compare a measured frame with pressures (taxels,) [Pa] simulated in its posture.

    Raises:
        LiveError: Same as for ``check_comparable``, or the frame is of another skin.
    """
    check_comparable(frame)
    if frame.pressures.shape != simulated.shape:
        found = f"{len(frame.pressures)} taxels for {len(simulated)}"
        raise LiveError("the readings and the simulation have different skins", value=found)
    return SkinDifference(frame.pressures, simulated)
