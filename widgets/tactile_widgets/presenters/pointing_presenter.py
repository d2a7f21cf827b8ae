"""The context menu of both views: what is pointed at, and what can be done with it.

``POINTED_ACTIONS`` is the one list of what a right click offers on either view and on a plot; each entry says for what
it is there and how it is called then.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from PySide6.QtCore import QObject, QPoint, Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QMenu, QWidget

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.core.arrays import FloatArray
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.tactile.poke import PokeState
from tactile_widgets.actions.mnemonics import with_mnemonic
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.document.map_editor import MapEditor
from tactile_widgets.panels.touch.contacts_panel import ContactsPanel
from tactile_widgets.panels.touch.held_fingers import FIRST_HELD
from tactile_widgets.plots.choice.plot_choice import PlotKey, PlotKind
from tactile_widgets.presenters.files.figure_presenter import FigurePresenter
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
"""A finger or a pin this near to the place pointed at is meant [m]."""


@dataclass(frozen=True, eq=False)
class Pointed:
    """What is pointed at, and all that is known of it.

    Attributes:
        at: The place of the skin; None beside it.
        body: Number of the link, or of the object behind the links, where there is no skin.
        name: Of the patch, link or object; empty for nothing.
        taxel: The nearest of the patch.
        region: The contact there.
        finger: The finger that stays there.
        pin: The pin there.
        link: Name of the link that is pointed at, bare or under skin.
        joint: Name of the joint that moves this link against the one before; None where none does.
        plot: The plot that is pointed at, in place of all others.
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
    """An entry of the menu.

    Attributes:
        name: In code and for tests.
        words: For what is pointed at; empty where it is not offered.
        act: Do it.
    """

    name: str
    words: Callable[[PointingPresenter, Pointed], str]
    act: Callable[[PointingPresenter, Pointed], None]


class PointingPresenter(QObject):
    """Opens the context menu on right clicks.

    Args:
        context: What it works on.
        tools: Path, target and pins.
        touch: Fingers on the skin.
        plots: What can be plotted.
        figure: Saves pictures of plots.
        parent: Qt parent; the menu opens over it.
    """

    def __init__(
        self,
        context: AppContext,
        tools: Tools,
        touch: TouchPresenter,
        plots: PlotsPresenter,
        figure: FigurePresenter,
        parent: QWidget,
    ) -> None:
        super().__init__(parent)
        self.context = context
        self.tools = tools
        self.touch = touch
        self.plots = plots
        self.figure = figure
        self._window = parent
        self.menu: QMenu | None = None
        context.views.menu_requested.connect(self.open_menu)
        context.plots.menu_requested.connect(self.open_plot_menu)

    def open_menu(self, hit: PointedAt, place: QPoint) -> None:
        """Offer what can be done with what is there; nothing where there is nothing."""
        self._offer(self.resolve(hit), place)

    def open_plot_menu(self, plot: PlotKey, place: QPoint) -> None:
        """Offer what can be done with a plot."""
        self._offer(Pointed(plot=plot), place)

    def _offer(self, pointed: Pointed, place: QPoint) -> None:
        offered = [(action, words) for action in POINTED_ACTIONS if (words := action.words(self, pointed))]
        if not offered:
            return
        menu = self.menu = QMenu(self._window)
        menu.setObjectName("pointed-menu")
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        for action, words in offered:
            entry = menu.addAction(with_mnemonic(words, ""))
            entry.setObjectName(f"pointed-{action.name}")
            entry.triggered.connect(lambda _checked=False, action=action: action.act(self, pointed))
        menu.popup(place)

    def resolve(self, hit: PointedAt) -> Pointed:
        """All that is known of what is there now."""
        prepared = self.context.session.prepared
        frame = self.context.session.shown
        if prepared is None:
            return Pointed()
        if hit.at is None:
            link = _link_name(prepared, hit.body)
            name = _body_name(prepared, hit.body)
            return Pointed(body=hit.body, name=name, link=link, joint=_joint_name(prepared, link))
        document = self.context.editor.document if self.context.editor.enabled else None
        at = hit.at
        taxel = nearest_taxel(prepared.map if document is None else document.map, hit.at)
        link = prepared.skin.patches[at.patch].link
        return Pointed(
            at,
            None,
            prepared.skin.patches[at.patch].name,
            taxel,
            _region(frame, taxel),
            _finger(prepared, frame, at),
            _pin(self.context.editor, at),
            link,
            _joint_name(prepared, link),
        )

    def neighbours(self, plot: PlotKey | None, step: int) -> tuple[PlotKey | None] | None:
        """Which plot ``plot`` would stand left of, one place before (-1) or behind (1); None where it cannot."""
        shown = [key for key in self.context.plots.shown_keys if key not in self.context.plots.board.windows]
        if plot is None or plot not in shown or not 0 <= shown.index(plot) + step < len(shown):
            return None
        place = shown.index(plot) + (step if step < 0 else 2)
        return (shown[place] if place < len(shown) else None,)

    def body_of(self, pointed: Pointed) -> int | None:
        """The number of the link, bare or under skin, or of the object behind the links, that is pointed at."""
        prepared = self.context.session.prepared
        if prepared is None or pointed.at is None or pointed.link is None:
            return pointed.body
        return prepared.robot.link_index[pointed.link]

    @property
    def running(self) -> bool:
        """Whether there is a simulation to touch."""
        return self.context.session.simulating

    def map_point(self, at: SurfacePoint) -> FloatArray | None:
        """(2,) the place on the map that the arm is led on; None while none can be."""
        control = self.tools.control
        return control.map.to_map(at) if control.enabled and control.map is not None else None


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
    """The last joint before a link: its own, or that of the nearest link before it that has one."""
    if link is None:
        return None
    before = Configuration(prepared.robot).joints_before(link)
    return prepared.robot.joints[int(before[-1])].name if len(before) else None


def _region(frame: Frame | None, taxel: int | None) -> ContactRegion | None:
    regions = () if frame is None or taxel is None else frame.regions
    return next((region for region in regions if taxel in region.taxels), None)


def _near(prepared_position: Callable[[SurfacePoint], FloatArray], one: SurfacePoint, other: SurfacePoint) -> bool:
    apart = prepared_position(one) - prepared_position(other)
    return one.patch == other.patch and float(np.linalg.norm(apart)) <= NEAR


def _finger(prepared: PreparedScene, frame: Frame | None, at: SurfacePoint) -> PokeState | None:
    pokes = () if frame is None else frame.pokes
    held = (poke for poke in pokes if poke.id >= FIRST_HELD)
    return next((poke for poke in held if _near(prepared.skin.position, poke.at, at)), None)


def _pin(editor: MapEditor, at: SurfacePoint) -> SurfacePoint | None:
    document = editor.document
    if document is None or not editor.enabled:  # a recording that is shown may wear another skin
        return None
    return next((pin for pin in pins_by_point(document) if _near(document.skin.position, pin, at)), None)


# What is offered.


def _poke_words(presenter: PointingPresenter, pointed: Pointed) -> str:
    force = presenter.touch.fingers.held.value()
    wanted = presenter.running and pointed.at is not None and pointed.finger is None
    return f"Poke here with {force:g}\u202fN, and stay" if wanted else ""


def _poke(presenter: PointingPresenter, pointed: Pointed) -> None:
    if pointed.at is not None:
        presenter.touch.hold(pointed.at)


def _away_words(_presenter: PointingPresenter, pointed: Pointed) -> str:
    return "" if pointed.finger is None else f"Take the finger away ({pointed.finger.force:.1f}\u202fN)"


def _away(presenter: PointingPresenter, pointed: Pointed) -> None:
    if pointed.finger is not None:
        presenter.touch.remove(pointed.finger.id)


def _force_words(presenter: PointingPresenter, pointed: Pointed) -> str:
    return "Type its force" if pointed.finger is not None and presenter.running else ""


def _type_force(presenter: PointingPresenter, pointed: Pointed) -> None:
    if pointed.finger is not None:
        presenter.context.panels.reveal(presenter.context.panels.get(ContactsPanel))
        presenter.touch.fingers.edit_force(pointed.finger.id)


def _target_words(presenter: PointingPresenter, pointed: Pointed) -> str:
    return "Put the target here" if pointed.at is not None and presenter.map_point(pointed.at) is not None else ""


def _set_target(presenter: PointingPresenter, pointed: Pointed) -> None:
    point = None if pointed.at is None else presenter.map_point(pointed.at)
    if point is not None:
        presenter.tools.control.do("set the target", task="hold_point", path=as_points(point[None]))


def _path_words(presenter: PointingPresenter, pointed: Pointed) -> str:
    return "Start a path here" if pointed.at is not None and presenter.map_point(pointed.at) is not None else ""


def _start_path(presenter: PointingPresenter, pointed: Pointed) -> None:
    point = None if pointed.at is None else presenter.map_point(pointed.at)
    if point is not None:
        presenter.tools.take(PATH)
        presenter.tools.get(PathTool).start_at(point)


def _plot_words(_presenter: PointingPresenter, pointed: Pointed) -> str:
    return "" if pointed.region is None else "Plot this contact"


def _plot(presenter: PointingPresenter, pointed: Pointed) -> None:
    if pointed.region is not None:
        presenter.plots.plot(PlotKey(PlotKind.CONTACT, str(pointed.region.id)))
        presenter.context.views.selection.select_region(pointed.region.id)


def _plot_taxel_words(_presenter: PointingPresenter, pointed: Pointed) -> str:
    return "" if pointed.taxel is None else f"Plot taxel {pointed.taxel}"


def _plot_taxel(presenter: PointingPresenter, pointed: Pointed) -> None:
    if pointed.taxel is not None:
        presenter.plots.plot(PlotKey(PlotKind.TAXEL, str(pointed.taxel)))
        presenter.context.views.select_taxel(pointed.taxel)


def _plot_group_words(presenter: PointingPresenter, pointed: Pointed) -> str:
    count = len(presenter.context.views.selection.taxels)
    return f"Plot this group of {count} taxels…" if pointed.taxel is not None and count > 1 else ""


def _plot_group(presenter: PointingPresenter, _pointed: Pointed) -> None:
    presenter.plots.ask_group(presenter.context.views.selection.taxels.tolist())


def _plot_link_words(presenter: PointingPresenter, pointed: Pointed) -> str:
    prepared = presenter.context.session.prepared
    skinned = prepared is not None and any(patch.link == pointed.link for patch in prepared.skin.patches)
    return f"Plot the force on {(pointed.link or '').replace('_', ' ')}" if skinned else ""


def _plot_link(presenter: PointingPresenter, pointed: Pointed) -> None:
    if pointed.link is not None:
        presenter.plots.plot(PlotKey(PlotKind.LINK, pointed.link))


def _plot_joint_words(_presenter: PointingPresenter, pointed: Pointed) -> str:
    return "" if pointed.joint is None else f"Plot joint {pointed.joint.replace('_', ' ')}"


def _plot_joint(presenter: PointingPresenter, pointed: Pointed) -> None:
    if pointed.joint is not None:
        presenter.plots.plot(PlotKey(PlotKind.JOINT, pointed.joint))


def _enlarge_words(presenter: PointingPresenter, pointed: Pointed) -> str:
    board = presenter.context.plots.board
    if pointed.plot is None or pointed.plot in board.windows:
        return ""
    return "Show all plots" if board.enlarged == pointed.plot else "Enlarge"


def _enlarge(presenter: PointingPresenter, pointed: Pointed) -> None:
    if pointed.plot is not None:
        presenter.context.plots.board.toggle(pointed.plot)


def _pop_out_words(presenter: PointingPresenter, pointed: Pointed) -> str:
    if pointed.plot is None:
        return ""
    return "Put back among the plots" if pointed.plot in presenter.context.plots.board.windows else "Own window"


def _pop_out(presenter: PointingPresenter, pointed: Pointed) -> None:
    if pointed.plot is not None:
        presenter.context.plots.pop_out(pointed.plot)


def _move_words(step: int, presenter: PointingPresenter, pointed: Pointed) -> str:
    ways = ("left", "right") if presenter.context.plots.board.horizontal else ("up", "down")
    return "" if presenter.neighbours(pointed.plot, step) is None else f"Move {ways[step > 0]}"


def _move(step: int, presenter: PointingPresenter, pointed: Pointed) -> None:
    found = presenter.neighbours(pointed.plot, step)
    if found is not None and pointed.plot is not None:
        presenter.context.plots.move_plot(pointed.plot, *found)


def _hide_plot_words(_presenter: PointingPresenter, pointed: Pointed) -> str:
    return "" if pointed.plot is None else "Hide this plot"


def _hide_plot(presenter: PointingPresenter, pointed: Pointed) -> None:
    if pointed.plot is not None:
        presenter.context.plots.remove_plot(pointed.plot)


def _save_plot_words(_presenter: PointingPresenter, pointed: Pointed) -> str:
    return "" if pointed.plot is None else "Save as CSV…"


def _save_plot(presenter: PointingPresenter, pointed: Pointed) -> None:
    if pointed.plot is not None:
        presenter.plots.save_table((pointed.plot,))


def _frame_words(_presenter: PointingPresenter, pointed: Pointed) -> str:
    return f"Frame {pointed.name.replace('_', ' ')}" if pointed.name else ""


def _frame(presenter: PointingPresenter, pointed: Pointed) -> None:
    if pointed.at is not None:
        presenter.context.views.frame_patch(pointed.at)
    elif pointed.body is not None:
        presenter.context.views.robot.display.frame_body(pointed.body)


def _hide_words(presenter: PointingPresenter, pointed: Pointed) -> str:
    hides = pointed.at is not None and presenter.context.editor.enabled
    return f"Hide {pointed.name.replace('_', ' ')} on the map" if hides else ""


def _hide(presenter: PointingPresenter, pointed: Pointed) -> None:
    if pointed.at is not None:
        presenter.context.editor.select((pointed.at.patch,))
        presenter.context.actions["hide_patches"].trigger()


def _hide_body_words(presenter: PointingPresenter, pointed: Pointed) -> str:
    if presenter.body_of(pointed) is None:
        return ""
    return f"Hide {(pointed.link or pointed.name).replace('_', ' ')} in the robot view"


def _hide_body(presenter: PointingPresenter, pointed: Pointed) -> None:
    robot = presenter.context.views.robot
    body = presenter.body_of(pointed)
    if body is not None:
        robot.hide_bodies(robot.display.actors.hidden | {body})


def _show_bodies_words(presenter: PointingPresenter, pointed: Pointed) -> str:
    hidden = len(presenter.context.views.robot.display.actors.hidden)
    return f"Show all in the robot view ({hidden} hidden)" if hidden and pointed.plot is None else ""


def _show_bodies(presenter: PointingPresenter, _pointed: Pointed) -> None:
    presenter.context.actions["show_bodies"].trigger()


def _unpin_words(presenter: PointingPresenter, pointed: Pointed) -> str:
    return "Remove this pin" if pointed.pin is not None and presenter.context.editor.enabled else ""


def _unpin(presenter: PointingPresenter, pointed: Pointed) -> None:
    if pointed.pin is not None:
        presenter.tools.get(PinTool).remove_at(pointed.pin)


def _figure_words(_presenter: PointingPresenter, pointed: Pointed) -> str:
    return "" if pointed.plot is None else "Save figure…"


def _figure(presenter: PointingPresenter, pointed: Pointed) -> None:
    if pointed.plot is not None:
        presenter.figure.ask((pointed.plot,))


def _seam_words(presenter: PointingPresenter, pointed: Pointed) -> str:
    if pointed.at is None or not presenter.context.editor.enabled:
        return ""
    return "Erase this seam" if presenter.tools.get(SeamTool).has_seam(pointed.at) else ""


def _erase_seam(presenter: PointingPresenter, pointed: Pointed) -> None:
    if pointed.at is not None:
        presenter.tools.get(SeamTool).erase_at(pointed.at)


def _frame_seam_words(presenter: PointingPresenter, pointed: Pointed) -> str:
    return "Frame this seam" if pointed.at is not None and presenter.tools.get(SeamTool).has_seam(pointed.at) else ""


def _frame_seam(presenter: PointingPresenter, pointed: Pointed) -> None:
    if pointed.at is not None and (found := presenter.tools.get(SeamTool).seam(pointed.at)) is not None:
        document, patch, vertices = found
        sides = on_map(document, patch, as_edges(vertices)).reshape(-1, 2)
        presenter.context.views.frame_seam(patch, vertices, sides)


def _copy_words(_presenter: PointingPresenter, pointed: Pointed) -> str:
    return "Copy values" if pointed.name or pointed.plot is not None else ""


def _copy(presenter: PointingPresenter, pointed: Pointed) -> None:
    if pointed.plot is not None:
        QGuiApplication.clipboard().setText(presenter.context.plots.table((pointed.plot,)))
    else:
        QGuiApplication.clipboard().setText(_values(presenter, pointed))
    presenter.context.notifier.status("Copied")


def _values(presenter: PointingPresenter, pointed: Pointed) -> str:
    told = presenter.context.views.map.words_for(pointed.at) or pointed.name
    lines = [told.replace("\u202f", " ")]
    if pointed.region is not None:
        region = pointed.region
        lines.append(f"Contact {region.id}: {region.force:.4g} N, {region.area:.4g} m², peak {region.peak:.4g} Pa")
    if pointed.at is not None and (length := presenter.tools.get(SeamTool).seam_length(pointed.at)) is not None:
        lines.append(f"Seam: {length:.4g} m long")
    lines += _body_values(presenter.context.session.prepared, presenter.context.session.shown, pointed)
    return "\n".join(lines)


def _body_values(prepared: PreparedScene | None, frame: Frame | None, pointed: Pointed) -> list[str]:
    """Where a bare link or an object is, and how its joint stands."""
    lines: list[str] = []
    if prepared is None or frame is None or pointed.at is not None:
        return lines
    links = len(prepared.robot.links)
    if pointed.body is not None and pointed.body >= links:
        lines.append(f"Place: {_numbers(frame.objects[pointed.body - links][:3, 3])} m")
    if pointed.joint is not None:
        number = [joint.name for joint in prepared.robot.joints].index(pointed.joint)
        unit = "m" if prepared.robot.joints[number].slide else "rad"
        told = f"{frame.posture[number]:.4g} {unit}, {frame.velocity[number]:.4g} {unit}/s"
        lines.append(f"Joint {pointed.joint}: {told}")
    return lines


def _numbers(values: FloatArray) -> str:
    return " ".join(f"{value:.4g}" for value in values.tolist())


POINTED_ACTIONS = (
    PointedAction("poke", _poke_words, _poke),
    PointedAction("away", _away_words, _away),
    PointedAction("force", _force_words, _type_force),
    PointedAction("target", _target_words, _set_target),
    PointedAction("path", _path_words, _start_path),
    PointedAction("plot", _plot_words, _plot),
    PointedAction("plot-taxel", _plot_taxel_words, _plot_taxel),
    PointedAction("plot-group", _plot_group_words, _plot_group),
    PointedAction("plot-link", _plot_link_words, _plot_link),
    PointedAction("plot-joint", _plot_joint_words, _plot_joint),
    PointedAction("frame", _frame_words, _frame),
    PointedAction("frame-seam", _frame_seam_words, _frame_seam),
    PointedAction("hide", _hide_words, _hide),
    PointedAction("hide-body", _hide_body_words, _hide_body),
    PointedAction("show-bodies", _show_bodies_words, _show_bodies),
    PointedAction("unpin", _unpin_words, _unpin),
    PointedAction("erase-seam", _seam_words, _erase_seam),
    PointedAction("enlarge", _enlarge_words, _enlarge),
    PointedAction("pop-out", _pop_out_words, _pop_out),
    PointedAction("earlier", partial(_move_words, -1), partial(_move, -1)),
    PointedAction("later", partial(_move_words, 1), partial(_move, 1)),
    PointedAction("hide-plot", _hide_plot_words, _hide_plot),
    PointedAction("save-plot", _save_plot_words, _save_plot),
    PointedAction("figure", _figure_words, _figure),
    PointedAction("copy", _copy_words, _copy),
)
"""In the order of the menu, the same in both views and on plots."""
