"""Depth model: MuJoCo's tactile sensor read as a bed of springs, for comparison with the other models.

Each taxel is one point. Its pressure is the layer's stiffness per area times the depth of the point in the touching
body. It is blind between taxels, and the sum of pressure times area is not the contact's force.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import mujoco
import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.robots.model.mujoco_spec import OWN_NAMES
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.contact_notes import ContactNote, ContactNoteKind
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.mechanics.loads import Load
from tactile_maps.tactile.models.water_fill import WaterFillModel

_UNUSED_BIT = 1 << 20
_SOLID = 0.1 * np.array([[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]])
_SOLID_FACES = np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])
"""Unused tetrahedron: MuJoCo requires a mesh with a volume, and moves one whose centre is not the origin."""


def add_taxel_sensors(spec: mujoco.MjSpec, skin: Skin, presses: Callable[[str], bool]) -> None:
    """Give each link of ``skin`` a tactile sensor with its taxels as points.

    Args:
        spec: Model with all collision shapes; changed.
        skin: The skin.
        presses: Whether a mesh of that name may touch skin; it gets the signed distance that the sensor requires
            (0.2 s a mesh), without which it would read 0.
    """
    for mesh in spec.meshes:
        if presses(mesh.name):
            mesh.needsdf = 1
    shell = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
    for link, positions in _positions(skin).items():
        name = _sensor_name(link)
        vertices = np.concatenate([positions, _SOLID])
        faces = _SOLID_FACES + len(positions)
        spec.add_mesh(name=name, uservert=vertices.ravel().tolist(), userface=faces.ravel().tolist(), inertia=shell)
        # The sensor's points are in the frame of a geom that may collide. This one has the frame of the link, and a bit
        # of its own, so that it never collides.
        spec.body(link).add_geom(
            name=name,
            type=mujoco.mjtGeom.mjGEOM_SPHERE,
            size=[1e-3, 0, 0],
            mass=0.0,
            contype=_UNUSED_BIT,
            conaffinity=0,
            group=3,
        )
        spec.add_sensor(
            name=name,
            type=mujoco.mjtSensor.mjSENS_TACTILE,
            objtype=mujoco.mjtObj.mjOBJ_MESH,
            objname=name,
            reftype=mujoco.mjtObj.mjOBJ_GEOM,
            refname=name,
        )


class DepthModel:
    """Pressure from MuJoCo's tactile sensors, and from fingers by the same formula. See the module.

    Error: see ``stated_errors``; a small body between taxels is not measured at all. Cost: within the physics step, 1.5
    to 5 times a bare one for 1000 taxels.

    Args:
        model: The compiled model, with sensors where the skin may be touched.
        data: Its state.
        skin: The skin.
        layer: The skin's cover, for its stiffness per area.
        averages: Whether depths are the mean of all steps since ``begin``.
        contacts: Returns the loads of the solver's contacts, which are used for notes.

    Attributes:
        notes: Notes on loads outside the skin, from the water-fill model.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        skin: Skin,
        layer: ElasticLayer,
        *,
        averages: bool = False,
        contacts: Callable[[], Sequence[Load]] = tuple,
    ) -> None:
        self._contacts = contacts
        self._fill = WaterFillModel(skin, layer=layer)
        self.notes: tuple[ContactNote, ...] = ()
        self._data = data
        self._skin = skin
        self._foundation = layer.foundation
        self._positions = _positions(skin)
        counted = np.split(np.arange(len(skin)), skin.first[1:-1])
        self._taxels = {
            link: np.concatenate([n for n, patch in zip(counted, skin.patches, strict=True) if patch.link == link])
            for link in self._positions
        }
        self._outputs = {
            link: int(model.sensor(_sensor_name(link)).adr[0])
            for link in self._positions
            if mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, _sensor_name(link)) >= 0
        }

        self._averages = averages
        self._sums = np.zeros(len(data.sensordata))
        self._steps = 0

    def begin(self) -> None:
        """Begin a tick."""
        self._sums[:] = 0.0
        self._steps = 0

    def look(self) -> None:
        """Add the last step to the mean."""
        if self._averages:
            self._sums += self._data.sensordata
            self._steps += 1

    def pressures(self, loads: Sequence[Load]) -> FloatArray:
        """Return the pressures (taxels,) [Pa] for the deepest of all bodies, as in MuJoCo's sensor.

        Args:
            loads: Loads of fingers; other bodies are in the sensor data.
        """
        depth = np.zeros(len(self._skin))
        read = self._sums / self._steps if self._steps else self._data.sensordata
        for link, first in self._outputs.items():
            taxels = self._taxels[link]
            depth[taxels] = read[first : first + len(taxels)]
        for load in loads:
            if load.link in self._taxels:
                taxels = self._taxels[load.link]
                inside = -load.shape.distance(load.pose.inverse.points(self._positions[load.link]))
                depth[taxels] = np.maximum(depth[taxels], inside)
        self._fill.pressures([*loads, *self._contacts()])
        self.notes = tuple(note for note in self._fill.notes if note.kind is not ContactNoteKind.SKIN_EDGE)
        return self._foundation * depth


def _sensor_name(link: str) -> str:
    return f"{OWN_NAMES}taxels {link}"


def _positions(skin: Skin) -> dict[str, FloatArray]:
    """Return the positions (k, 3) of each link's taxels [m], link frame."""
    return {
        link: np.concatenate([patch.taxels.positions for patch in skin.patches if patch.link == link])
        for link in skin.links
    }
