"""The context menu of both views: what is pointed at, and what can be done with it.

``POINTED_ACTIONS`` is the one list of what a right click offers; each entry says for what it is there and how it is
called then. Fingers that stay are put, changed and taken away here.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from PySide6.QtCore import QObject, QPoint, Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QMenu, QWidget

from app.contacts.regions import ContactRegion
from app.core.arrays import FloatArray
from app.geometry.mesh import SurfacePoint
from app.session.frame import Frame
from app.session.prepare import PreparedScene
from app.tactile.poke import PokeState
from widgets.actions.mnemonics import with_mnemonic
from widgets.context.app_context import AppContext
from widgets.document.map_editor import MapEditor
from widgets.interaction.pointed_at import PointedAt
from widgets.map_view.map_coordinates import nearest_taxel
from widgets.panels.touch.contacts_panel import ContactsPanel
from widgets.panels.touch.held_fingers import FIRST_HELD
from widgets.tools.control.drawn_path import as_points
from widgets.tools.control.path_tool import PathTool
from widgets.tools.map_editing.pin_tool import PinTool, pins_by_point
from widgets.tools.registry import PATH, Tools

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
    """

    at: SurfacePoint | None = None
    body: int | None = None
    name: str = ""
    taxel: int | None = None
    region: ContactRegion | None = None
    finger: PokeState | None = None
    pin: SurfacePoint | None = None


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
    """Answers right clicks and clicks with Shift on the views.

    Args:
        context: What it works on.
        tools: Path, target and pins.
        parent: Qt parent; the menu opens over it.
    """

    def __init__(self, context: AppContext, tools: Tools, parent: QWidget) -> None:
        super().__init__(parent)
        self.context, self.tools, self._window = context, tools, parent
        self.fingers = context.panels.get(ContactsPanel).fingers
        self.menu: QMenu | None = None
        context.views.menu_requested.connect(self.open_menu)
        context.views.latch_requested.connect(self.hold)
        context.views.poke_pressed.connect(self.press)
        context.session.taken_over.connect(self._on_taken_over)
        context.actions.bind("take_over", context.session.take_over)

    # Fingers.

    def press(self, at: SurfacePoint) -> None:
        """The mouse presses the skin."""
        if self._can_touch():
            self.context.session.press(at)

    def _can_touch(self) -> bool:
        """Whether what is shown can be pressed; else say why not, and offer what helps."""
        session, notifier, actions = self.context.session, self.context.notifier, self.context.actions
        if session.player is not None:
            notifier.say("This is a recording: it cannot be pressed.", remedies=[actions["take_over"]])
            return False
        if session.simulating and session.source is not None and not session.source.settings.effects.fingers:
            notifier.say("No finger is simulated in this scene.", remedies=[actions["simulate_fingers"]])
            return False
        return True

    def _on_taken_over(self, seconds: float, same: bool) -> None:
        words = f"Taken over at {seconds:.2f}\u2009s"
        if same:
            self.context.notifier.status(f"{words}, in the recorded state bit for bit")
        else:
            self.context.notifier.say(
                f"{words}. Posture and speed differ from the recorded ones: it was recorded by other versions of the "
                "program or its libraries."
            )

    def hold(self, at: SurfacePoint) -> None:
        """Leave a finger at a place of the skin."""
        if self._can_touch():
            self.context.session.hold_finger(at, self.fingers.held.value())

    # The menu.

    def open_menu(self, hit: PointedAt, place: QPoint) -> None:
        """Offer what can be done with what is there; nothing where there is nothing."""
        pointed = self.resolve(hit)
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
        prepared, frame = self.context.session.prepared, self.context.session.shown
        if prepared is None:
            return Pointed()
        if hit.at is None:
            return Pointed(body=hit.body, name=_body_name(prepared, hit.body))
        at, map_ = hit.at, prepared.map
        taxel = nearest_taxel(map_, at)
        return Pointed(
            at,
            None,
            prepared.skin.patches[at.patch].name,
            taxel,
            _region(frame, taxel),
            _finger(prepared, frame, at),
            _pin(self.context.editor, at),
        )

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
    return links[body].name if body < len(links) else prepared.objects[body - len(links)].spec.name


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
    force = presenter.fingers.held.value()
    wanted = presenter.running and pointed.at is not None and pointed.finger is None
    return f"Poke here with {force:g}\u2009N, and stay" if wanted else ""


def _poke(presenter: PointingPresenter, pointed: Pointed) -> None:
    if pointed.at is not None:
        presenter.hold(pointed.at)


def _away_words(_presenter: PointingPresenter, pointed: Pointed) -> str:
    return "" if pointed.finger is None else f"Take the finger away ({pointed.finger.force:.1f}\u2009N)"


def _away(presenter: PointingPresenter, pointed: Pointed) -> None:
    if pointed.finger is not None:
        presenter.context.session.take_finger_away(pointed.finger.id)


def _force_words(presenter: PointingPresenter, pointed: Pointed) -> str:
    return "Type its force" if pointed.finger is not None and presenter.running else ""


def _type_force(presenter: PointingPresenter, pointed: Pointed) -> None:
    if pointed.finger is not None:
        presenter.context.panels.reveal(presenter.context.panels.get(ContactsPanel))
        presenter.fingers.edit_force(pointed.finger.id)


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
    if pointed.region is not None:
        return "Plot this contact"
    return "" if pointed.taxel is None else f"Plot taxel {pointed.taxel}"


def _plot(presenter: PointingPresenter, pointed: Pointed) -> None:
    context = presenter.context
    if not context.actions["plots"].isChecked():
        context.actions["plots"].trigger()
    if pointed.region is not None:
        context.views.selection.select_region(pointed.region.id)
    elif pointed.taxel is not None:
        context.views.select_taxel(pointed.taxel)


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


def _unpin_words(presenter: PointingPresenter, pointed: Pointed) -> str:
    return "Remove this pin" if pointed.pin is not None and presenter.context.editor.enabled else ""


def _unpin(presenter: PointingPresenter, pointed: Pointed) -> None:
    if pointed.pin is not None:
        presenter.tools.get(PinTool).remove_at(pointed.pin)


def _copy_words(_presenter: PointingPresenter, pointed: Pointed) -> str:
    return "Copy values" if pointed.name else ""


def _copy(presenter: PointingPresenter, pointed: Pointed) -> None:
    told = presenter.context.views.map.display.words_for(pointed.at) or pointed.name
    lines = [told.replace("\u2009", " ")]
    if pointed.region is not None:
        region = pointed.region
        lines.append(f"Contact {region.id}: {region.force:.4g} N, {region.area:.4g} m², peak {region.peak:.4g} Pa")
    QGuiApplication.clipboard().setText("\n".join(lines))
    presenter.context.notifier.status("Copied")


POINTED_ACTIONS = (
    PointedAction("poke", _poke_words, _poke),
    PointedAction("away", _away_words, _away),
    PointedAction("force", _force_words, _type_force),
    PointedAction("target", _target_words, _set_target),
    PointedAction("path", _path_words, _start_path),
    PointedAction("plot", _plot_words, _plot),
    PointedAction("frame", _frame_words, _frame),
    PointedAction("hide", _hide_words, _hide),
    PointedAction("unpin", _unpin_words, _unpin),
    PointedAction("copy", _copy_words, _copy),
)
"""In the order of the menu, the same in both views."""
