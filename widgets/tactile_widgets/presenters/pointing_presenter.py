"""Context menu of both views and of the plots: the object under the pointer and the actions for it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from PySide6.QtCore import QPoint
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QMenu, QWidget

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.core.arrays import FloatArray
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.poke import PokeState
from tactile_widgets.common.make import DELETED_ON_CLOSE, add_entry, make
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.context.presenter import Presenter
from tactile_widgets.document.map_editor import MapEditor
from tactile_widgets.panels.touch.contacts_panel import ContactsPanel
from tactile_widgets.panels.touch.held_fingers import FIRST_HELD
from tactile_widgets.plots.choice.plot_choice import PlotKey, PlotKind
from tactile_widgets.presenters.files.figure_presenter import FigurePresenter
from tactile_widgets.presenters.files.skin_presenter import SkinPresenter
from tactile_widgets.presenters.plots_presenter import PlotsPresenter
from tactile_widgets.presenters.touch_presenter import TouchPresenter
from tactile_widgets.tools.control.drawn_path import as_points
from tactile_widgets.tools.control.path_tool import PathTool
from tactile_widgets.tools.map_editing.mesh_picking import as_edges, on_map
from tactile_widgets.tools.map_editing.pin_tool import PinTool, pins_by_point
from tactile_widgets.tools.map_editing.seam_tool import SeamTool
from tactile_widgets.tools.registry import PATH, Tools
from tactile_widgets.views.interaction.view_tool import PointedAt
from tactile_widgets.views.map.items.map_coordinates import nearest_taxel

NEAR = 0.012
"""Maximum distance of a finger or a pin from the pointer [m]."""


@dataclass(frozen=True, eq=False)
class Pointed:
    """Object under the pointer.

    Attributes:
        at: Point of the skin; None without skin.
        body: Number of the link, or of the object after the links, where there is no skin.
        name: Name of the patch, link or object; empty if there is none.
        taxel: Nearest taxel of the patch.
        region: Contact at the point.
        finger: Finger that stays there.
        pin: Pin there.
        link: Name of the link, bare or under skin.
        joint: Name of the joint that moves this link relative to the previous one; None without one.
        plot: Plot; everything else is None then.
    """

    at: SurfacePoint | None = None
    body: int | None = None
    name: str = ""
    taxel: int | None = None
    region: ContactRegion | None = None
    finger: PokeState | None = None
    pin: SurfacePoint | None = None
    link: str | None = None
    joint: str | None = None
    plot: PlotKey | None = None


class PointedAction(NamedTuple):
    """Entry of the menu.

    Attributes:
        name: Identifier, for tests.
        text: Text of the entry.
        run: Executes it.
    """

    name: str
    text: str
    run: Callable[[], object]


class PointingPresenter(Presenter):
    """Opens the context menu on right clicks.

    Args:
        context: Session, views, panels and services of the window.
        tools: Tools for path, target, pins and seams.
        touch: Fingers on the skin.
        plots: Adds plots and saves their samples.
        figure: Saves figures of plots.
        skin: Covers links, and removes their skin.
        parent: Window over which the menu opens.
    """

    def __init__(
        self,
        context: AppContext,
        tools: Tools,
        touch: TouchPresenter,
        plots: PlotsPresenter,
        figure: FigurePresenter,
        skin: SkinPresenter,
        parent: QWidget,
    ) -> None:
        super().__init__(context, parent)
        self._tools = tools
        self._touch = touch
        self._plots = plots
        self._figure = figure
        self._skin = skin
        self.menu: QMenu | None = None
        context.views.menu_requested.connect(self.open_menu)
        context.plots.menu_requested.connect(self.open_plot_menu)

    def open_menu(self, hit: PointedAt, place: QPoint) -> None:
        """Open the menu for a point of a view; nothing if there is no object."""
        self._open(self.resolve(hit), place)

    def open_plot_menu(self, plot: PlotKey, place: QPoint) -> None:
        """Open the menu for a plot."""
        self._open(Pointed(plot=plot), place)

    def _open(self, pointed: Pointed, place: QPoint) -> None:
        actions = [*self.actions(pointed)]
        if not actions:
            return
        menu = self.menu = make(QMenu, self._window, objectName="pointed-menu", attribute=DELETED_ON_CLOSE)
        for action in actions:
            add_entry(menu, action.text, action.run, objectName=f"pointed-{action.name}")
        menu.popup(place)

    def resolve(self, hit: PointedAt) -> Pointed:
        """Return the object at a point of a view."""
        prepared = self._session.prepared
        frame = self._session.shown
        if prepared is None:
            return Pointed()
        if hit.at is None:
            link = _link_name(prepared, hit.body)
            name = _body_name(prepared, hit.body)
            return Pointed(body=hit.body, name=name, link=link, joint=_joint_name(prepared, link))
        document = self._context.editor.document if self._context.editor.enabled else None
        at = hit.at
        taxel = nearest_taxel(prepared.map if document is None else document.map, hit.at)
        patch = prepared.skin.patches[at.patch]
        return Pointed(
            at,
            name=patch.name,
            taxel=taxel,
            region=_region(frame, taxel),
            finger=_finger(prepared, frame, at),
            pin=_pin(self._context.editor, at),
            link=patch.link,
            joint=_joint_name(prepared, patch.link),
        )

    # Entries of the menu, the same in both views and on plots, in order.

    def actions(self, pointed: Pointed) -> Iterator[PointedAction]:
        """Yield the entries for an object, in order."""
        yield from self._touch_actions(pointed)
        yield from self._plotting_actions(pointed)
        yield from self._display_actions(pointed)
        yield from self._edit_actions(pointed)
        yield from self._skin_actions(pointed)
        if pointed.plot is not None:
            yield from self._plot_actions(pointed.plot)
        if pointed.name or pointed.plot is not None:
            yield PointedAction("copy", "Copy values", partial(self._copy, pointed))

    def _touch_actions(self, pointed: Pointed) -> Iterator[PointedAction]:
        touch = self._touch
        control = self._tools.control
        finger = pointed.finger
        simulating = self._session.simulating
        if finger is not None:
            text = f"Take the finger away ({finger.force:.1f}\u202fN)"
            yield PointedAction("away", text, partial(touch.remove, finger.id))
            if simulating:
                yield PointedAction("force", "Type its force", partial(self._edit_force, finger.id))
        elif simulating and pointed.at is not None:
            force = touch.fingers.held.value()
            text = f"Poke here with {force:g}\u202fN, and stay"
            yield PointedAction("poke", text, partial(touch.hold, pointed.at))
        if pointed.at is not None and control.enabled and control.map is not None:
            point = control.map.to_map(pointed.at)
            target = partial(control.do, "set the target", task="hold_point", path=as_points(point[None]))
            yield PointedAction("target", "Put the target here", target)
            yield PointedAction("path", "Start a path here", partial(self._start_path, point))

    def _edit_force(self, finger: int) -> None:
        self._context.panels.reveal(self._context.panels.get(ContactsPanel))
        self._touch.fingers.edit_force(finger)

    def _start_path(self, point: FloatArray) -> None:
        self._tools.take(PATH)
        self._tools.get(PathTool).start_at(point)

    def _plotting_actions(self, pointed: Pointed) -> Iterator[PointedAction]:
        views = self._context.views
        if (region := pointed.region) is not None:
            key = PlotKey(PlotKind.CONTACT, str(region.id))
            select_region = partial(views.selection.select_region, region.id)
            yield PointedAction("plot", "Plot this contact", partial(self._plot, key, select_region))
        if (taxel := pointed.taxel) is not None:
            key = PlotKey(PlotKind.TAXEL, str(taxel))
            select_taxel = partial(views.select_taxel, taxel)
            yield PointedAction("plot-taxel", f"Plot taxel {taxel}", partial(self._plot, key, select_taxel))
            taxels = views.selection.taxels
            if len(taxels) > 1:
                text = f"Plot this group of {len(taxels)} taxels…"
                yield PointedAction("plot-group", text, partial(self._plots.ask_group, taxels.tolist()))
        prepared = self._session.prepared
        if (link := pointed.link) is not None and prepared is not None:
            if any(patch.link == link for patch in prepared.skin.patches):
                plot = partial(self._plot, PlotKey(PlotKind.LINK, link))
                yield PointedAction("plot-link", f"Plot the force on {_spaced(link)}", plot)
            if (joint := pointed.joint) is not None:
                plot = partial(self._plot, PlotKey(PlotKind.JOINT, joint))
                yield PointedAction("plot-joint", f"Plot joint {_spaced(joint)}", plot)

    def _plot(self, key: PlotKey, select: Callable[[], object] | None = None) -> None:
        self._plots.plot(key)
        if select is not None:
            select()

    def _display_actions(self, pointed: Pointed) -> Iterator[PointedAction]:
        views = self._context.views
        editable = self._context.editor.enabled
        name = _spaced(pointed.name)
        at = pointed.at
        if at is not None:
            yield PointedAction("frame", f"Frame {name}", partial(views.frame_patch, at))
            if self._tools.get(SeamTool).has_seam(at):
                yield PointedAction("frame-seam", "Frame this seam", partial(self._frame_seam, at))
            if editable:
                yield PointedAction("hide", f"Hide {name} on the map", partial(self._hide_patch, at.patch))
        elif pointed.body is not None:
            yield PointedAction("frame", f"Frame {name}", partial(views.robot.display.frame_body, pointed.body))
        hidden = views.robot.display.actors.hidden
        if (body := self._body(pointed)) is not None:
            text = f"Hide {_spaced(pointed.link or pointed.name)} in the robot view"
            yield PointedAction("hide-body", text, partial(views.robot.hide_bodies, hidden | {body}))
        if hidden and pointed.plot is None:
            text = f"Show all in the robot view ({len(hidden)} hidden)"
            yield PointedAction("show-bodies", text, self._context.actions["show_bodies"].trigger)

    def _body(self, pointed: Pointed) -> int | None:
        """Return the number of the link, bare or under skin, or of the object after the links."""
        prepared = self._session.prepared
        if prepared is None or pointed.at is None or pointed.link is None:
            return pointed.body
        return prepared.robot.link_index[pointed.link]

    def _frame_seam(self, at: SurfacePoint) -> None:
        if (found := self._tools.get(SeamTool).seam(at)) is not None:
            document, patch, vertices = found
            sides = on_map(document, patch, as_edges(vertices)).reshape(-1, 2)
            self._context.views.frame_seam(patch, vertices, sides)

    def _hide_patch(self, patch: int) -> None:
        self._context.editor.select((patch,))
        self._context.actions["hide_patches"].trigger()

    def _edit_actions(self, pointed: Pointed) -> Iterator[PointedAction]:
        seams = self._tools.get(SeamTool)
        if not self._context.editor.enabled:
            return
        if pointed.pin is not None:
            remove = partial(self._tools.get(PinTool).remove_at, pointed.pin)
            yield PointedAction("unpin", "Remove this pin", remove)
        if pointed.at is not None and seams.has_seam(pointed.at):
            yield PointedAction("erase-seam", "Erase this seam", partial(seams.erase_at, pointed.at))

    def _skin_actions(self, pointed: Pointed) -> Iterator[PointedAction]:
        link = pointed.link
        if link in self._skin.coverable:
            yield PointedAction("cover", "Cover this link", partial(self._skin.cover_link, link))
        if link in self._skin.removable:
            yield PointedAction("remove-skin", "Remove the skin of this link", partial(self._skin.remove_skin, link))

    def _plot_actions(self, plot: PlotKey) -> Iterator[PointedAction]:
        plots = self._context.plots
        board = plots.board
        own_window = plot in board.windows
        if not own_window:
            text = "Show all plots" if board.enlarged == plot else "Enlarge"
            yield PointedAction("enlarge", text, partial(board.toggle, plot))
        text = "Put back among the plots" if own_window else "Own window"
        yield PointedAction("pop-out", text, partial(plots.pop_out, plot))
        docked = [key for key in plots.shown_keys if key not in board.windows]
        place = -1 if own_window or plot not in docked else docked.index(plot)
        previous, following = ("left", "right") if board.horizontal else ("up", "down")
        if place > 0:
            move = partial(plots.move_plot, plot, docked[place - 1])
            yield PointedAction("earlier", f"Move {previous}", move)
        if 0 <= place < len(docked) - 1:
            move = partial(plots.move_plot, plot, docked[place + 2] if place + 2 < len(docked) else None)
            yield PointedAction("later", f"Move {following}", move)
        yield PointedAction("hide-plot", "Hide this plot", partial(plots.remove_plot, plot))
        yield PointedAction("save-plot", "Save as CSV…", partial(self._plots.save_table, (plot,)))
        yield PointedAction("figure", "Save figure…", partial(self._figure.ask, (plot,)))

    def _copy(self, pointed: Pointed) -> None:
        plot = pointed.plot
        text = self._values(pointed) if plot is None else self._context.plots.table((plot,))
        QGuiApplication.clipboard().setText(text)
        self._notifier.status("Copied")

    def _values(self, pointed: Pointed) -> str:
        readout = self._context.views.map.words_for(pointed.at) or pointed.name
        lines = [readout.replace("\u202f", " ")]
        if (region := pointed.region) is not None:
            lines.append(f"Contact {region.id}: {region.force:.4g} N, {region.area:.4g} m², peak {region.peak:.4g} Pa")
        if pointed.at is not None and (length := self._tools.get(SeamTool).seam_length(pointed.at)) is not None:
            lines.append(f"Seam: {length:.4g} m long")
        lines += _body_values(self._session.prepared, self._session.shown, pointed)
        return "\n".join(lines)


def _spaced(name: str) -> str:
    return name.replace("_", " ")


def _body_name(prepared: PreparedScene, body: int | None) -> str:
    if body is None:
        return ""
    links = prepared.robot.links
    if body < len(links) and links[body].missing:
        return f"{links[body].name} (missing: {', '.join(links[body].missing)})"
    return links[body].name if body < len(links) else prepared.objects[body - len(links)].spec.name


def _link_name(prepared: PreparedScene, body: int | None) -> str | None:
    links = prepared.robot.links
    return links[body].name if body is not None and body < len(links) else None


def _joint_name(prepared: PreparedScene, link: str | None) -> str | None:
    """Return the last joint before a link: its own, or that of the nearest previous link that has one."""
    if link is None:
        return None
    before = Configuration(prepared.robot).joints_before(link)
    return prepared.robot.joints[int(before[-1])].name if len(before) else None


def _region(frame: Frame | None, taxel: int | None) -> ContactRegion | None:
    regions = () if frame is None or taxel is None else frame.regions
    return next((region for region in regions if taxel in region.taxels), None)


def _near(skin: Skin, one: SurfacePoint, other: SurfacePoint) -> bool:
    distance = np.linalg.norm(skin.position(one) - skin.position(other))
    return one.patch == other.patch and float(distance) <= NEAR


def _finger(prepared: PreparedScene, frame: Frame | None, at: SurfacePoint) -> PokeState | None:
    pokes = () if frame is None else frame.pokes
    held = (poke for poke in pokes if poke.id >= FIRST_HELD)
    return next((poke for poke in held if _near(prepared.skin, poke.at, at)), None)


def _pin(editor: MapEditor, at: SurfacePoint) -> SurfacePoint | None:
    document = editor.document
    if document is None or not editor.enabled:  # a recording that is shown may have another skin
        return None
    return next((pin for pin in pins_by_point(document) if _near(document.skin, pin, at)), None)


def _body_values(prepared: PreparedScene | None, frame: Frame | None, pointed: Pointed) -> list[str]:
    """Return the position of an object, or position and speed of the joint of a bare link."""
    lines: list[str] = []
    if prepared is None or frame is None or pointed.at is not None:
        return lines
    links = len(prepared.robot.links)
    if pointed.body is not None and pointed.body >= links:
        place = frame.objects[pointed.body - links][:3, 3]
        lines.append(f"Place: {' '.join(f'{value:.4g}' for value in place.tolist())} m")
    if pointed.joint is not None:
        number = prepared.robot.joint_names.index(pointed.joint)
        unit = "m" if prepared.robot.joints[number].slide else "rad"
        motion = f"{frame.posture[number]:.4g} {unit}, {frame.velocity[number]:.4g} {unit}/s"
        lines.append(f"Joint {pointed.joint}: {motion}")
    return lines
