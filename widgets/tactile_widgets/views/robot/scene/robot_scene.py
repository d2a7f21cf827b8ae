"""The robot as actors on any PyVista plotter: built once a robot, then updated in place.

With what a layer of View > Overlay is on the body, so that the scene needs to know none by name.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
import pyvista as pv

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.session.frame import Frame
from tactile_maps.session.link_levels import LinkLevels
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.common.colours import PressureScale, Theme, mixed
from tactile_widgets.overlays.taxel_faults import TaxelFaults
from tactile_widgets.views.overlays.body_overlays import SkinTexture, ToolMarks
from tactile_widgets.views.overlays.task_overlay import TaskOverlay
from tactile_widgets.views.robot.scene.camera import CameraRay, Viewpoint, framing
from tactile_widgets.views.robot.scene.contact_marks import ContactMarks
from tactile_widgets.views.robot.scene.fault_marks import FaultMarks
from tactile_widgets.views.robot.scene.link_actors import LinkActors
from tactile_widgets.views.robot.scene.object_actors import ObjectActors, floor_grid
from tactile_widgets.views.robot.scene.opening_view import initial_direction, places_of_interest
from tactile_widgets.views.robot.scene.skin_actors import PEELED, SkinActors
from tactile_widgets.views.robot.scene.surface_marks import set_matrix
from tactile_widgets.views.robot.scene.tool_and_task_marks import EditToolMarks, TaskMarks

_STILL = 2e-5
"""Joints and objects that move less [rad, m] do not change a pixel."""
_FADE = 0.94
"""How much of the bare links goes when the skin lies flat; a shadow of the robot stays."""
_FLAT_FILL = 0.8
"""Share of the picture that the flat skin takes."""


class BodyLayer:
    """What a layer of View > Overlay draws on the body: a subclass overrides what it needs. Made once a robot.

    Args:
        scene: Whose body it is drawn on; its ``plotter``, ``prepared``, ``skin`` and ``theme`` are there.

    Attributes:
        replaces_image: Whether touch is left out of the skin's colours while it is shown.
        shown: Whether it is to be seen.
    """

    replaces_image: ClassVar[bool] = False

    def __init__(self, scene: RobotScene) -> None:
        self.scene = scene
        self.shown = False

    def set_shown(self, *, shown: bool) -> None:
        """Show it from the next ``show_frame`` and ``colour`` on, which follow at once; or hide it now."""
        self.shown = shown

    def show_frame(self, frame: Frame, poses: FloatArray) -> None:
        """Place it as of ``frame``, the skin being on the body; ``poses`` (links, 4, 4) are ``T_world_link``."""

    def hide(self) -> None:
        """The skin is off the body: what does not go with it shows nothing until the next ``show_frame``."""

    def colour(self, pressures: FloatArray, scale: PressureScale) -> None:
        """Take the pressures (taxels,) [Pa], wherever the skin is."""

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""


BodyLayerFactory = Callable[["RobotScene"], BodyLayer]
"""Makes a layer for a scene."""


class RobotScene:
    """Links, skin, objects, contacts and fingers of one prepared scene. Mutable; ``show_prepared`` replaces everything.

    Args:
        plotter: Where to draw; its actors are this scene's alone.
        theme: Colours of everything that is not skin.
        scale: Colours of pressure.
        layers: Makes each layer that is drawn on the body, by name.

    Attributes:
        plotter: As above.
        theme: As above, or as set since.
        skin: The skin's actors; like ``prepared``, ``links`` and the ``layers``, there from ``show_prepared`` on.
        links: The bare links' actors.
        link_levels: Coarser surfaces of some robot's links; None for none.
        layers: Those of this scene, by name.
        hidden: The links, and the objects behind the links, by number, that are left out.
    """

    def __init__(
        self, plotter: Any, theme: Theme, scale: PressureScale, layers: Mapping[str, BodyLayerFactory] | None = None
    ) -> None:
        self.plotter = plotter
        self.theme = theme
        self._scale = scale
        self._prepared: PreparedScene | None = None
        self._frame: Frame | None = None
        self.link_levels: LinkLevels | None = None
        self._bounds: list[tuple[int, FloatArray]] = []
        self._make_layers = dict(layers or {})
        self._shown = frozenset[str]()
        self.layers: dict[str, BodyLayer] = {}
        self.hidden: frozenset[int] = frozenset()
        self._light_and_ground()

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Draw another robot, at home, framed; of the same one with the same objects what was hidden stays so."""
        self.plotter.clear_actors()
        if self._prepared is None or _bodies(self._prepared) != _bodies(prepared):
            self.hidden = frozenset()
        self._prepared = prepared
        self._frame = None
        self._configuration = Configuration(prepared.robot)
        self.skin = SkinActors(self.plotter, prepared, self._scale)  # before the links, most of which it hides
        self.links = LinkActors(self.plotter, prepared.robot, self.theme)
        self.links.set_levels(self.link_levels)
        meshes = ((number, link.mesh) for number, link in enumerate(prepared.robot.links))
        self._bounds = [(number, mesh.bounds) for number, mesh in meshes if mesh is not None and len(mesh.faces)]
        self._bounds += [(prepared.robot.link_index[p.link], p.surface.bounds) for p in prepared.skin.patches]
        self._objects = ObjectActors(self.plotter, self.theme, prepared.objects)
        self._plane = np.eye(4)
        self._marks = ContactMarks(self.plotter, self.theme, prepared)
        self.layers = {name: make(self) for name, make in self._make_layers.items()}
        self._edit_marks = EditToolMarks(self.plotter, self.theme, prepared)
        self._task_marks = TaskMarks(self.plotter, self.theme, prepared)
        self._fault_marks = FaultMarks(self.plotter, self.theme, prepared)
        self._carried = (self._fault_marks, self._edit_marks, self._task_marks)
        self.show_layers(self._shown)
        self._ground()
        self._places = places_of_interest(prepared, self.poses)
        self._away = initial_direction(prepared, self.poses, self._places)
        self.frame_all()
        self.fit_depth()

    def show_frame(self, frame: Frame) -> None:
        """Move links and colour skin, in place; the caller renders."""
        if self._prepared is None:
            return
        self._frame = frame
        self._configuration.update(frame.posture)
        self._objects.move(frame.objects)
        self._move()
        self._colour()
        self._mark()

    def _mark(self) -> None:
        """Marks and layers where the frame has them; none while the skin is off the body."""
        if self._frame is None:
            return
        if self.morphed:
            self._marks.hide()
            for layer in self.layers.values():
                layer.hide()
            return
        frame = self._seen_of(self._frame)
        self._marks.show_frame(frame, self.poses)
        for layer in self.layers.values():
            layer.show_frame(frame, self.poses)

    def _seen_of(self, frame: Frame) -> Frame:
        """A frame without what touches links that are hidden."""
        if not self.hidden:
            return frame
        robot = self.prepared.robot
        skin = self.prepared.skin
        names = {link.name for number, link in enumerate(robot.links) if number not in self.hidden}
        return replace(
            frame,
            regions=tuple(region for region in frame.regions if region.link in names),
            pokes=tuple(poke for poke in frame.pokes if skin.link(poke.at) in names),
        )

    def hide(self, bodies: frozenset[int]) -> None:
        """Leave out these links, with their skin and its marks, and objects behind the links; no others."""
        self.hidden = bodies
        if self._prepared is not None:
            self._move()
            self._mark()

    def _leave_out(self) -> None:
        """Take the actors of what is hidden off the picture: whether they are otherwise to be seen stays theirs."""
        marks = [pair for kind in self._carried for pair in kind.link_actors]
        actors = [*self.links.placed, *self.skin.link_actors, *marks]
        first = len(self.prepared.robot.links)
        actors += [*self.skin.textured_actors, *((first + number, actor) for number, actor in self._objects.actors)]
        renderer = self.plotter.renderer
        for number, actor in actors:
            if (shown := number not in self.hidden) != bool(renderer.HasViewProp(actor)):
                (renderer.AddViewProp if shown else renderer.RemoveViewProp)(actor)

    def shows(self, frame: Frame) -> bool:
        """Whether ``frame`` would look like the one shown: an arm at rest need not be drawn again and again."""
        shown = self._frame
        return shown is not None and (
            shown is frame
            or (
                frame.units is shown.units
                and bool(np.abs(frame.posture - shown.posture).max(initial=0.0) < _STILL)
                and bool(np.abs(frame.pressures - shown.pressures).max(initial=0.0) < 1e3 * self._scale.maximum / 256)
                and bool(np.abs(frame.objects - shown.objects).max(initial=0.0) < _STILL)
                and len(frame.pokes) == len(shown.pokes)
                and [f"{r.id} {r.force:.2f}" for r in frame.regions] == [f"{r.id} {r.force:.2f}" for r in shown.regions]
            )
        )

    def set_hover(self, at: SurfacePoint | None) -> None:
        """Mark a place on the skin; None for none."""
        if self._prepared is not None:
            self._marks.set_hover(None if at is None else self.point(at))

    def point(self, at: SurfacePoint) -> tuple[FloatArray, FloatArray] | None:
        """Where a place on the skin is drawn [m], and its outward normal; None without a robot."""
        return None if self._prepared is None else self.skin.point(at, self.poses, self._plane)

    def set_selection(self, taxels: IntArray, inks: tuple[str, ...]) -> None:
        """Ring these taxels (k,), each in its colour."""
        if self._prepared is not None:
            self.skin.select(taxels, inks)

    def set_faults(self, faults: TaxelFaults) -> None:
        """Mark dead, stuck and blind taxels."""
        if self._prepared is not None:
            self._fault_marks.show(faults)

    def set_picture(self, picture: SkinTexture | None, *, textured: bool) -> None:
        """Take the map's picture: shown while ``textured``, else kept for the way to the map."""
        if self._prepared is not None:
            self.skin.set_texture(picture, always=textured)
            self._move()
            self._colour()

    def set_marks(self, marks: ToolMarks) -> None:
        """Show what an edit tool marks on the body."""
        if self._prepared is not None:
            self._edit_marks.show(marks)

    def show_task(self, task: TaskOverlay) -> None:
        """Show what a controller with a task wants, and what came of it."""
        if self._prepared is not None:
            self._task_marks.show(task)

    def show_layers(self, shown: frozenset[str]) -> None:
        """Show the layers of these names and no others; at once, since no other frame may come."""
        self._shown = shown
        for name, layer in self.layers.items():
            layer.set_shown(shown=name in shown)
        if self._prepared is not None:
            self.skin.bare = any(layer.shown and layer.replaces_image for layer in self.layers.values())
            self._move()
            self._colour()
        self._mark()

    def show_map(self, map_: TactileMap) -> None:
        """The same skin on another map."""
        if self._prepared is not None:
            self._prepared = replace(self._prepared, map=map_)
            self.skin.show_map(map_)
            self._move()
            self._colour()

    def morph(self, share: float) -> None:
        """Lay the skin flat by this share: 0 on the body, 1 as on the map, facing the eye as it was at the start."""
        if self._prepared is None:
            return
        if self.skin.share == 0:
            self._plane = self._facing_plane()
        self.skin.morph(share)
        for marks in self._carried:
            marks.hide(hidden=share > 0)
        gone = _FADE * min(share / PEELED, 1.0)  # before the skin is laid flat, which would lead through the links
        self.links.fade(gone)
        self._objects.fade(gone)
        self._move()
        self._colour()
        self._mark()

    @property
    def morphed(self) -> bool:
        """Whether the skin is off the body."""
        return self._prepared is not None and self.skin.share > 0

    def _facing_plane(self) -> FloatArray:
        """(4, 4) ``T_world_map``: upright in the middle of the picture, as near as all of the map is in it."""
        assert self._prepared is not None
        view, (width, height) = self.viewpoint, self.plotter.window_size
        (right, up, forward), bounds = view.axes, self._prepared.map.bounds
        plane = np.eye(4)
        plane[:3, :3] = np.stack([right, up, -forward], axis=1)
        reach = np.tan(np.radians(view.view_angle) / 2) * _FLAT_FILL * np.array([width / height, 1.0])
        away = float((np.ptp(bounds, axis=0) / 2 / reach).max())
        plane[:3, 3] = view.eye + away * forward - plane[:3, :2] @ bounds.mean(axis=0)
        return plane

    def pick_flat(self, ray: CameraRay) -> SurfacePoint | None:
        """The place of the skin that a ray (world frame) meets first, while it is off the body; None beside it."""
        return self.skin.pick(ray) if self.morphed else None

    def flat_taxels(self) -> tuple[FloatArray, FloatArray]:
        """Positions [m] and unit normals, (taxels, 3) each, world frame, of the skin off the body."""
        return self.skin.taxels(self.poses, self._plane)

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        self.theme = theme
        self.plotter.set_background(theme.window)
        if self._prepared is not None:
            self.links.set_theme(theme)
            self._marks.set_theme(theme)
            for layer in self.layers.values():
                layer.set_theme(theme)
            self._objects.set_theme(theme)
            for marks in self._carried:
                marks.set_theme(theme)
            self._ground()

    def set_scale(self, scale: PressureScale) -> None:
        """Take another pressure scale."""
        self._scale = scale
        if self._prepared is not None:
            self._colour()

    @property
    def prepared(self) -> PreparedScene:
        """Robot, skin and map, as drawn."""
        assert self._prepared is not None
        return self._prepared

    @property
    def poses(self) -> FloatArray:
        """(links, 4, 4) ``T_world_link`` as drawn."""
        return self._configuration.poses()

    @property
    def body_poses(self) -> FloatArray:
        """(links + objects, 4, 4) in the world, as drawn."""
        return np.concatenate([self.poses, self._objects.poses])

    @property
    def forces(self) -> list[tuple[FloatArray, ContactRegion]]:
        """Each force arrow's tail and tip (2, 3) [m], world, and the region whose force it stands for."""
        return self._marks.forces if self._prepared is not None else []

    @property
    def viewpoint(self) -> Viewpoint:
        """Where the eye is."""
        return Viewpoint.of(self.plotter.camera)

    def look(self, viewpoint: Viewpoint) -> None:
        """Look from there."""
        viewpoint.to(self.plotter.camera)
        self.plotter.camera.is_set = True  # or PyVista would look from its own default place at the first render

    def turn_opening(self, angle: float) -> None:
        """Let ``frame_all`` look from a direction turned about the vertical by ``angle`` [rad]."""
        if self._prepared is not None:
            (x, y, z), c, s = self._away.tolist(), np.cos(angle), np.sin(angle)
            self._away = np.array([c * x - s * y, s * x + c * y, z])

    def frame_all(self, *, aspect: float | None = None) -> None:
        """Look at everything, three quarters from the front and slightly from above, the first contact in the middle.

        Args:
            aspect: Width by height of the picture; by default the plotter's.
        """
        if self._prepared is not None:
            width, height = self.plotter.window_size
            robot = self._corners()
            first = len(self.prepared.robot.links)
            points = np.concatenate([robot, self._objects.near(robot, {body - first for body in self.hidden})])
            shape = aspect or width / height
            central = self._places.points
            self.look(framing(points, self._away, shape, view_angle=30.0, fill=0.92, central=central))

    def set_link_levels(self, levels: LinkLevels | None) -> None:
        """Draw links as coarse as ``fit_detail`` finds fit, of any robot that these are of; None for never."""
        self.link_levels = levels
        if self._prepared is not None:
            self.links.set_levels(levels)

    def fit_detail(self, height: float) -> None:
        """Let links be as fine as a picture of this height [px] can show; before each picture."""
        if self._prepared is not None:
            self.links.choose(self.viewpoint, height, self.poses)

    def fit_depth(self) -> None:
        """Let the camera's depth hold all that is drawn; before each picture, since the robot moves."""
        self.plotter.renderer.ResetCameraClippingRange()

    def _corners(self) -> FloatArray:
        """(k, 3) corners of all links' and patches' boxes, world [m], but for hidden ones; of all if none is left."""
        poses = self.poses
        parts = []
        shown = [one for one in self._bounds if one[0] not in self.hidden]
        for number, bounds in shown or self._bounds:
            corners = np.array(np.meshgrid(*bounds.T)).reshape(3, -1).T
            parts.append(corners @ poses[number][:3, :3].T + poses[number][:3, 3])
        return np.concatenate(parts)

    def _move(self) -> None:
        poses = self.poses
        for number, actor in self.links.placed:
            set_matrix(actor, poses[number])
        for marks in self._carried:
            for number, actor in marks.link_actors:
                set_matrix(actor, poses[number])
        self.skin.move(poses, self._plane)
        self._leave_out()

    def _colour(self) -> None:
        assert self._prepared is not None
        pressures = np.zeros(len(self._prepared.skin)) if self._frame is None else self._frame.pressures
        self.skin.colour(pressures, self._scale)
        for layer in self.layers.values():
            layer.colour(pressures, self._scale)

    def _light_and_ground(self) -> None:
        self.plotter.set_background(self.theme.window)
        # What is seen through is blended as it comes, without two more pictures in floating point for its order: a
        # third of the time to draw five fingertips, and no pixel differs while they do not overlap.
        self.plotter.renderer.SetUseOIT(False)
        self.plotter.remove_all_lights()
        # One headlight, a little above the eye, so that shape shows without hiding colour.
        self.plotter.add_light(pv.Light(position=(0.25, 0.45, 1.0), light_type="camera light", intensity=0.95))

    def _ground(self) -> None:
        """A faint grid on the floor, unless the scene has a floor of its own."""
        if self._objects.has_floor:
            self.plotter.remove_actor("ground", render=False)
            return
        colour = mixed(self.theme.window, self.theme.quiet, 0.28)
        self.plotter.add_mesh(
            floor_grid(self._corners()),
            color=colour, line_width=1, lighting=False, name="ground", pickable=False, reset_camera=False,
        )  # fmt: skip


def _bodies(prepared: PreparedScene) -> tuple[str, ...]:
    """What can be hidden of a scene, by name."""
    return (*(link.name for link in prepared.robot.links), *(body.spec.name for body in prepared.objects))
