"""Actors of a robot on a PyVista plotter: built once per robot, then updated in place.

``BodyLayer`` is the base class of the layers of View > Overlay on the body.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
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
from tactile_maps.skin.formats.import_skin import NO_ROBOT
from tactile_maps.skin.model.skin import Skin
from tactile_widgets.common.colours import PressureScale, Theme, mixed
from tactile_widgets.overlays.taxel_faults import TaxelFaults
from tactile_widgets.views.overlays.body_overlays import SkinTexture, ToolMarks
from tactile_widgets.views.overlays.legend import Legend
from tactile_widgets.views.overlays.task_overlay import NO_TASK, TaskOverlay
from tactile_widgets.views.robot.actors.camera import CameraRay, Viewpoint, box_corners, framing
from tactile_widgets.views.robot.actors.contact_marks import ContactMarks
from tactile_widgets.views.robot.actors.fault_marks import FaultMarks
from tactile_widgets.views.robot.actors.link_actors import LinkActors
from tactile_widgets.views.robot.actors.object_actors import ObjectActors, floor_grid
from tactile_widgets.views.robot.actors.opening_view import PlacesOfInterest, initial_direction, places_of_interest
from tactile_widgets.views.robot.actors.skin_actors import PEELED, SkinActors
from tactile_widgets.views.robot.actors.skin_preview_actors import SkinPreviewActors
from tactile_widgets.views.robot.actors.surface_marks import set_matrix
from tactile_widgets.views.robot.actors.tool_and_task_marks import EditToolMarks, TaskMarks

_STILL = 2e-5
"""Motion of joints and objects up to which no pixel changes [rad, m]."""
_FADE = 0.94
"""Transparency of the bare links while the skin is flat."""
_FLAT_FILL = 0.8
"""Fraction of the picture that the flat skin fills."""
_BEHIND = 100.0
"""Offset of the floor's lines away from the camera [VTK's units of depth]."""


class BodyLayer:
    """Layer of View > Overlay on the body; subclasses override what they need. Made once per robot.

    Args:
        actors: Actors of the robot; its ``plotter``, ``prepared``, ``skin`` and ``theme`` exist already.

    Attributes:
        replaces_image: Whether touch is left out of the skin's colours while the layer is shown.
        shown: Whether the layer is shown.
    """

    replaces_image: ClassVar[bool] = False

    def __init__(self, actors: RobotActors) -> None:
        self.actors = actors
        self.shown = False

    def set_shown(self, *, shown: bool) -> None:
        """Hide the layer now, or show it from the next ``show_frame`` and ``colour`` on, which follow at once."""
        self.shown = shown

    def show_frame(self, frame: Frame, poses: FloatArray) -> None:
        """Update for an instant with the skin on the body; ``poses`` (links, 4, 4) are ``T_world_link``."""

    def hide(self) -> None:
        """Hide whatever does not follow the skin off the body, until the next ``show_frame``."""

    def colour(self, pressures: FloatArray, scale: PressureScale) -> None:
        """Set the colours of the pressures (taxels,) [Pa], whether the skin is on the body or flattened."""

    def set_theme(self, theme: Theme) -> None:
        """Set the theme."""

    def arrows(self, viewpoint: Viewpoint, size: tuple[int, int]) -> FloatArray:
        """Return tail and tip (k, 2, 2) of arrows painted over a picture of this size, all in pixels."""
        return np.zeros((0, 2, 2))

    @property
    def legend(self) -> Legend | None:
        """Explanation of what is drawn now; None if nothing is to be explained."""
        return None


BodyLayerFactory = Callable[["RobotActors"], BodyLayer]
"""Makes a layer for the actors of a robot."""


class RobotActors:
    """Actors of links, skin, objects, contacts and fingers on a plotter; ``show_prepared`` makes those of other bodies.

    Args:
        plotter: Plotter that draws them, without other actors.
        theme: Colours of everything except the skin.
        scale: Colours of pressure.
        layers: Factories of the layers drawn on the body, by name.

    Attributes:
        plotter: The plotter.
        theme: Current theme.
        scale: Current pressure scale.
        skin: Actors of the skin; like ``prepared``, ``links`` and the ``layers``, it exists from ``show_prepared`` on.
        links: Actors of the bare links.
        link_levels: Coarser surfaces of some robot's links, or None.
        layers: Layers by name.
        hidden: Numbers of the hidden links, and of objects after the links.
    """

    def __init__(
        self, plotter: Any, theme: Theme, scale: PressureScale, layers: Mapping[str, BodyLayerFactory] | None = None
    ) -> None:
        self.plotter = plotter
        self.theme = theme
        self.scale = scale
        self._prepared: PreparedScene | None = None
        self._frame: Frame | None = None
        self.link_levels: LinkLevels | None = None
        self._bounds: list[tuple[int, FloatArray]] = []
        self._make_layers = dict(layers or {})
        self._shown = frozenset[str]()
        self.layers: dict[str, BodyLayer] = {}
        self.hidden: frozenset[int] = frozenset()
        self._preview: SkinPreviewActors | None = None
        self._floor: tuple[bytes, Theme] | None = None  # what the grid on the floor was drawn for
        self._places = PlacesOfInterest(np.zeros((0, 3)), np.zeros((0, 3)))
        self._set_light()

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Show another robot in its home posture, fitted to the view; with the same bodies, hidden ones stay hidden.

        Cost: 60 ms, or 5 ms if robot, skin and objects are those of the previous scene, whose actors are then kept.
        """
        self.set_preview(None)
        before = self._prepared
        if before is None or _bodies(before) != _bodies(prepared):
            self.hidden = frozenset()
        self._prepared = prepared
        self._frame = None
        self._configuration = Configuration(prepared.robot)
        self._plane = np.eye(4)
        if before is None or not _same_bodies(before, prepared):
            self._make_actors(prepared)
        else:
            self._reset_actors(prepared)
        self.show_layers(self._shown)
        self._add_floor()
        places = places_of_interest(prepared, self.poses)
        if before is None or before.robot is not prepared.robot or not places.equals(self._places):
            self._initial_away = initial_direction(prepared, self.poses, places)
        self._places = places
        self._away = self._initial_away
        self.frame_all()
        self.fit_depth()

    def _make_actors(self, prepared: PreparedScene) -> None:
        self.plotter.clear_actors()
        self._floor = None
        self.skin = SkinActors(self.plotter, prepared, self.scale)  # before the links, because it hides most of them
        self.links = LinkActors(self.plotter, prepared.robot, self.theme, below=prepared.scene.robot == NO_ROBOT)
        self.links.set_levels(self.link_levels)
        meshes = ((number, link.mesh) for number, link in enumerate(prepared.robot.links))
        self._bounds = [(number, mesh.bounds) for number, mesh in meshes if mesh is not None and len(mesh.faces)]
        self._bounds += [(prepared.robot.link_index[p.link], p.surface.bounds) for p in prepared.skin.patches]
        self._objects = ObjectActors(self.plotter, self.theme, prepared.objects)
        self._marks = ContactMarks(self.plotter, self.theme, prepared)
        self.layers = {name: make(self) for name, make in self._make_layers.items()}
        self._edit_marks = EditToolMarks(self.plotter, self.theme, prepared)
        self._task_marks = TaskMarks(self.plotter, self.theme, prepared)
        self._fault_marks = FaultMarks(self.plotter, self.theme, prepared)
        self._carried = (self._fault_marks, self._edit_marks, self._task_marks)

    def _reset_actors(self, prepared: PreparedScene) -> None:
        """Show the present actors as at the start: the skin on the body, without contacts, task and selection."""
        if self.morphed:
            self.morph(0.0)
        self.skin.show_map(prepared.map)
        self.skin.set_texture(None, always=False)
        self.skin.select(np.zeros(0, int), ())
        self._objects.move(np.array([body.spec.pose.matrix for body in prepared.objects]).reshape(-1, 4, 4))
        self._marks.hide()
        self._marks.set_hover(None)
        self._task_marks.show(NO_TASK)
        for layer in self.layers.values():
            layer.hide()

    def show_frame(self, frame: Frame) -> None:
        """Move links and colour the skin in place; the caller renders."""
        if self._prepared is None:
            return
        self._frame = frame
        self._configuration.update(frame.posture)
        self._objects.move(frame.objects)
        self._move()
        self._colour()
        self._mark()

    def _mark(self) -> None:
        """Place marks and layers; none while the skin is off the body."""
        if self._frame is None:
            return
        if self.morphed:
            self._marks.hide()
            for layer in self.layers.values():
                layer.hide()
            return
        frame = self._visible(self._frame)
        self._marks.show_frame(frame, self.poses)
        for layer in self.layers.values():
            layer.show_frame(frame, self.poses)

    def _visible(self, frame: Frame) -> Frame:
        """Return a frame without contacts and pokes on hidden links."""
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
        """Hide these links, with their skin and its marks, and objects, numbered after the links; show all others."""
        self.hidden = bodies
        if self._prepared is not None:
            self._move()
            self._mark()

    def shows(self, frame: Frame) -> bool:
        """Whether ``frame`` looks like the current one, so that an arm at rest is not drawn again."""
        shown = self._frame
        return shown is not None and (
            shown is frame
            or (
                frame.units is shown.units
                and bool(np.abs(frame.posture - shown.posture).max(initial=0.0) < _STILL)
                and bool(np.abs(frame.pressures - shown.pressures).max(initial=0.0) < 1e3 * self.scale.maximum / 256)
                and _same_shear(frame.shear, shown.shear, 1e3 * self.scale.maximum / 256)
                and bool(np.abs(frame.objects - shown.objects).max(initial=0.0) < _STILL)
                and len(frame.pokes) == len(shown.pokes)
                and [f"{r.id} {r.force:.2f}" for r in frame.regions] == [f"{r.id} {r.force:.2f}" for r in shown.regions]
            )
        )

    def set_hover(self, at: SurfacePoint | None) -> None:
        """Mark a skin location; None for no mark."""
        if self._prepared is not None:
            self._marks.set_hover(None if at is None else self.point(at))

    def point(self, at: SurfacePoint) -> tuple[FloatArray, FloatArray] | None:
        """Return position [m] and outward normal of a skin location as drawn; None without a robot."""
        return None if self._prepared is None else self.skin.point(at, self.poses, self._plane)

    def set_selection(self, taxels: IntArray, inks: tuple[str, ...]) -> None:
        """Draw a ring around each of these taxels (k,) in its colour."""
        if self._prepared is not None:
            self.skin.select(taxels, inks)

    def set_preview(self, skin: Skin | None) -> None:
        """Show a skin that is being chosen instead of the present one; None for the present one."""
        if self._preview is not None:
            self._preview.remove()
        previewed = self._preview is not None
        self._preview = None
        if self._prepared is not None and skin is not None:
            self._preview = SkinPreviewActors(self.plotter, self.prepared.robot, skin, self.theme)
        if self._prepared is not None and (previewed or self._preview is not None):
            self._move()

    def set_faults(self, faults: TaxelFaults) -> None:
        """Mark dead, stuck and blind taxels."""
        if self._prepared is not None:
            self._fault_marks.show(faults)

    def set_picture(self, picture: SkinTexture | None, *, textured: bool) -> None:
        """Set the map's image, shown on the skin if ``textured``, and always while the skin is flattened."""
        if self._prepared is not None:
            self.skin.set_texture(picture, always=textured)
            self._move()
            self._colour()

    def set_marks(self, marks: ToolMarks) -> None:
        """Show the marks of a tool."""
        if self._prepared is not None:
            self._edit_marks.show(marks)

    def show_task(self, task: TaskOverlay) -> None:
        """Show the controller's task."""
        if self._prepared is not None:
            self._task_marks.show(task)

    def show_layers(self, shown: frozenset[str]) -> None:
        """Show the layers of these names only, without waiting for the next tick."""
        self._shown = shown
        for name, layer in self.layers.items():
            layer.set_shown(shown=name in shown)
        if self._prepared is not None:
            self.skin.bare = any(layer.shown and layer.replaces_image for layer in self.layers.values())
            self._move()
            self._colour()
        self._mark()

    def show_map(self, map_: TactileMap) -> None:
        """Use another map of the same skin."""
        if self._prepared is not None:
            self._prepared = replace(self._prepared, map=map_)
            self.skin.show_map(map_)
            self._move()
            self._colour()

    def morph(self, share: float) -> None:
        """Flatten the skin by this amount: 0 on the body, 1 as on the map, facing the viewpoint of the start."""
        if self._prepared is None:
            return
        if self.skin.share == 0:
            self._plane = self._facing_plane()
        self.skin.morph(share)
        for marks in self._carried:
            marks.hide(hidden=share > 0)
        gone = _FADE * min(share / PEELED, 1.0)  # before the skin is flattened, because it passes through the links
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
        """(4, 4) ``T_world_map``: upright, in the centre of the picture, as close as the whole map is visible."""
        assert self._prepared is not None
        view = self.viewpoint
        width, height = self.plotter.window_size
        right, up, forward = view.axes
        bounds = self._prepared.map.bounds
        plane = np.eye(4)
        plane[:3, :3] = np.stack([right, up, -forward], axis=1)
        reach = np.tan(np.radians(view.view_angle) / 2) * _FLAT_FILL * np.array([width / height, 1.0])
        away = float((np.ptp(bounds, axis=0) / 2 / reach).max())
        plane[:3, 3] = view.eye + away * forward - plane[:3, :2] @ bounds.mean(axis=0)
        return plane

    def pick_flat(self, ray: CameraRay) -> SurfacePoint | None:
        """Return the first skin location along a ray (world frame) while the skin is off the body; None without one."""
        return self.skin.pick(ray) if self.morphed else None

    def flat_taxels(self) -> tuple[FloatArray, FloatArray]:
        """Return positions [m] and unit normals, (taxels, 3) each, world frame, of the skin off the body."""
        return self.skin.taxels(self.poses, self._plane)

    def set_theme(self, theme: Theme) -> None:
        """Set the theme."""
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
            if self._preview is not None:
                self._preview.set_theme(theme)
            self._add_floor()

    def set_scale(self, scale: PressureScale) -> None:
        """Set the pressure scale."""
        self.scale = scale
        if self._prepared is not None:
            self._colour()

    @property
    def prepared(self) -> PreparedScene:
        """Prepared scene as drawn."""
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
        """Tail and tip of each force arrow, (2, 3) [m], world, and the region whose force it shows."""
        return self._marks.forces if self._prepared is not None else []

    def arrows(self, viewpoint: Viewpoint, size: tuple[int, int]) -> FloatArray:
        """Return tail and tip (k, 2, 2) of the arrows of all layers, over a picture of this size [px]."""
        return np.concatenate([np.zeros((0, 2, 2)), *(one.arrows(viewpoint, size) for one in self._shown_layers)])

    @property
    def legends(self) -> tuple[Legend, ...]:
        """Legends of the layers that have something to explain."""
        legends = (layer.legend for layer in self._shown_layers)
        return tuple(legend for legend in legends if legend is not None)

    @property
    def _shown_layers(self) -> list[BodyLayer]:
        return [layer for layer in self.layers.values() if layer.shown]

    @property
    def viewpoint(self) -> Viewpoint:
        """Current viewpoint."""
        return Viewpoint.of(self.plotter.camera)

    def look(self, viewpoint: Viewpoint) -> None:
        """Set the viewpoint."""
        viewpoint.to(self.plotter.camera)
        self.plotter.camera.is_set = True  # otherwise PyVista sets its default viewpoint at the first render

    def turn_opening(self, angle: float) -> None:
        """Rotate the direction of ``frame_all`` about the vertical by ``angle`` [rad]."""
        if self._prepared is not None:
            x, y, z = self._away.tolist()
            c = np.cos(angle)
            s = np.sin(angle)
            self._away = np.array([c * x - s * y, s * x + c * y, z])

    def frame_all(self, *, aspect: float | None = None) -> None:
        """Show everything, obliquely from the front and slightly from above, with the first contact in the centre.

        Args:
            aspect: Width by height of the picture; by default that of the plotter.
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
        """Set coarser surfaces of links for ``fit_detail``, ignored for other robots; None if there is none."""
        self.link_levels = levels
        if self._prepared is not None:
            self.links.set_levels(levels)

    def fit_detail(self, height: float) -> None:
        """Select surfaces of links as fine as a picture of this height [px] can show; call before each picture."""
        if self._prepared is not None:
            self.links.choose(self.viewpoint, height, self.poses)

    def fit_depth(self) -> None:
        """Fit the camera's depth range to the robot; call before each picture."""
        self.plotter.renderer.ResetCameraClippingRange()

    def _corners(self) -> FloatArray:
        """(k, 3) corners of the boxes of shown links and patches, world [m]; of all if all are hidden."""
        poses = self.poses
        shown = [one for one in self._bounds if one[0] not in self.hidden]
        return np.concatenate([box_corners(bounds, poses[number]) for number, bounds in shown or self._bounds])

    def surface_points(self) -> FloatArray:
        """Return the vertices and the middles of the triangles of shown links and patches (k, 3), world [m]."""
        poses = self.poses
        meshes = [(number, link.mesh) for number, link in enumerate(self.prepared.robot.links) if link.mesh is not None]
        meshes += [(self.prepared.robot.link_index[p.link], p.surface) for p in self.prepared.skin.patches]
        placed = [
            np.concatenate([mesh.vertices, mesh.vertices[mesh.faces].mean(axis=1)]) @ poses[number][:3, :3].T
            + poses[number][:3, 3]
            for number, mesh in meshes
            if number not in self.hidden
        ]
        return np.concatenate([*placed, np.zeros((0, 3))])

    def _move(self) -> None:
        """Move all actors, and remove those of hidden bodies; their own visibility is not changed."""
        poses = self.poses
        marks = [pair for kind in self._carried for pair in kind.link_actors]
        for number, actor in (*self.links.placed, *marks):
            set_matrix(actor, poses[number])
        self.skin.move(poses, self._plane)
        first = len(self.prepared.robot.links)
        objects = [(first + number, actor) for number, actor in self._objects.actors]
        skin = (*self.skin.link_actors, *self.skin.textured_actors)
        preview = () if self._preview is None else self._preview.link_actors
        for number, actor in preview:
            set_matrix(actor, poses[number])
        previewed = self._preview is not None and not self.morphed
        self._show_actors((*self.links.placed, *objects), shown=True)
        self._show_actors((*skin, *marks), shown=not previewed)
        self._show_actors(preview, shown=previewed)

    def _show_actors(self, actors: Iterable[tuple[int, Any]], *, shown: bool) -> None:
        """Add actors to the picture, or remove them; those of hidden bodies are always removed."""
        renderer = self.plotter.renderer
        for number, actor in actors:
            if (visible := shown and number not in self.hidden) != bool(renderer.HasViewProp(actor)):
                (renderer.AddViewProp if visible else renderer.RemoveViewProp)(actor)

    def _colour(self) -> None:
        assert self._prepared is not None
        pressures = np.zeros(len(self._prepared.skin)) if self._frame is None else self._frame.pressures
        self.skin.colour(pressures, self.scale)
        for layer in self.layers.values():
            layer.colour(pressures, self.scale)

    def _set_light(self) -> None:
        self.plotter.set_background(self.theme.window)
        # Translucent actors are blended in drawing order, without two floating-point pictures that sort them: five
        # fingertips take a third of the time, and no pixel differs while they do not overlap.
        self.plotter.renderer.SetUseOIT(False)
        self.plotter.remove_all_lights()
        # One headlight, slightly above the camera, so that shape is visible without hiding colour.
        self.plotter.add_light(pv.Light(position=(0.25, 0.45, 1.0), light_type="camera light", intensity=0.95))

    def _add_floor(self) -> None:
        """Draw a faint grid on the floor, unless the scene has its own floor."""
        if self._objects.has_floor:
            self.plotter.remove_actor("ground", render=False)
            return
        corners = self._corners()
        if self._floor == (corners.tobytes(), self.theme):
            return
        self._floor = (corners.tobytes(), self.theme)
        colour = mixed(self.theme.window, self.theme.quiet, 0.28)
        floor = self.plotter.add_mesh(
            floor_grid(corners),
            color=colour,
            line_width=1,
            lighting=False,
            name="ground",
            pickable=False,
            reset_camera=False,
        )
        # VTK draws lines nearer than they are, here over the base of a robot. Nothing is below the floor.
        floor.mapper.SetRelativeCoincidentTopologyLineOffsetParameters(0, _BEHIND)


def _same_shear(one: FloatArray | None, other: FloatArray | None, least: float) -> bool:
    """Whether two frames have the same shear, or both none, up to differences below ``least`` [Pa]."""
    if one is None or other is None:
        return one is other
    return bool(np.abs(one - other).max(initial=0.0) < least)


def _bodies(prepared: PreparedScene) -> tuple[str, ...]:
    """Names of all bodies of a scene."""
    return (*(link.name for link in prepared.robot.links), *(body.spec.name for body in prepared.objects))


def _same_bodies(before: PreparedScene, after: PreparedScene) -> bool:
    """Whether two scenes share robot, skin and objects, not only equal ones."""
    parts = (before.robot, before.skin, *before.objects), (after.robot, after.skin, *after.objects)
    return len(parts[0]) == len(parts[1]) and all(one is other for one, other in zip(*parts, strict=True))
