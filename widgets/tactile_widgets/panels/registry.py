"""The panels by tab and from top to bottom: how each is constructed, and its connections to the session."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Any, Protocol, TypeVar

from tactile_widgets.common.guide_window import GuidePlace
from tactile_widgets.common.panel import Panel
from tactile_widgets.document.map_editor import MapEditor
from tactile_widgets.document.taxel_selection import TaxelSelection
from tactile_widgets.panels.control.behaviours_panel import BehavioursPanel
from tactile_widgets.panels.control.controller_panel import ControllerPanel
from tactile_widgets.panels.control.posture_panel import PosturePanel
from tactile_widgets.panels.history_panel import HistoryPanel
from tactile_widgets.panels.maps.compare_panel import ComparePanel
from tactile_widgets.panels.maps.patches_panel import PatchesPanel
from tactile_widgets.panels.maps.quality_panel import QualityPanel
from tactile_widgets.panels.model.accuracy_panel import AccuracyPanel
from tactile_widgets.panels.model.effects_panel import EffectsPanel
from tactile_widgets.panels.model.findings_panel import FindingsPanel, MessagesPanel
from tactile_widgets.panels.model.skin_panel import SkinPanel
from tactile_widgets.panels.model.timing_panel import TimingPanel
from tactile_widgets.panels.touch.connected_panel import ConnectedPanel
from tactile_widgets.panels.touch.contacts_panel import ContactsPanel
from tactile_widgets.panels.touch.events_panel import EventsPanel
from tactile_widgets.panels.touch.live_input_panel import LiveInputPanel
from tactile_widgets.panels.touch.requested_motion_panel import RequestedMotionPanel
from tactile_widgets.panels.touch.simulated_skin_panel import SimulatedSkinPanel
from tactile_widgets.panels.touch.skin_check_panel import SkinCheckPanel
from tactile_widgets.session.session_host import SessionHost

P = TypeVar("P", bound=Panel)


class Panels(Protocol):
    """The panels constructed so far."""

    def get(self, kind: type[P]) -> P:
        """Return the panel of a class."""


Make = Callable[[MapEditor, Panels], Panel]
Follow = Callable[[Any, SessionHost, TaxelSelection], None]


class PanelTab(Enum):
    """Tab of the column; its value is the label."""

    LIVE = "Live"
    TOUCH = "Touch"
    CONTROL = "Control"
    MAP = "Map"
    MODEL = "Model"

    @property
    def tip(self) -> str:
        """Tool tip."""
        return _TIPS[self]


_TIPS = {
    PanelTab.LIVE: "The connected skin: readings, calibration, motion for the robot",
    PanelTab.TOUCH: "Contacts and events on the skin",
    PanelTab.CONTROL: "Controller, reactions to contacts, and posture",
    PanelTab.MAP: "Patches, quality and history of the map",
    PanelTab.MODEL: "The skin; what is simulated, how accurately and at what cost; findings and messages",
}


@dataclass(frozen=True)
class PanelSpec:
    """A panel of the column.

    Attributes:
        tab: Tab that contains it.
        make: Constructs it for the editor of the map; it may connect the panel to those above it.
        guide: Place in the guide that describes it.
        follow: Connects the panel, the first argument, to session and selection; scenes and frames arrive through the
            hooks of ``Panel``. None for a panel that uses neither.
        folded_at_first: Whether it is folded until the user unfolds it.
    """

    tab: PanelTab
    make: Make
    guide: GuidePlace
    follow: Follow | None = None
    folded_at_first: bool = False


def _follow_controller(panel: ControllerPanel, session: SessionHost, _selection: TaxelSelection) -> None:
    session.settings_changed.connect(panel.show_settings)
    panel.settings_edited.connect(session.set_settings)


def _follow_contacts(panel: ContactsPanel, session: SessionHost, selection: TaxelSelection) -> None:
    session.reading_changed.connect(panel.show_reading)
    session.effects_changed.connect(panel.show_effects)
    panel.reading_edited.connect(session.set_reading)
    panel.follow(selection)


def _follow_behaviours(panel: BehavioursPanel, session: SessionHost, _selection: TaxelSelection) -> None:
    session.behaviours_changed.connect(panel.show_behaviours)
    session.triggered.connect(panel.show_triggered)
    panel.behaviours_edited.connect(session.set_behaviours)


def _follow_connection(panel: ConnectedPanel, session: SessionHost, selection: TaxelSelection) -> None:
    session.connection.changed.connect(panel.show_input)
    panel.follow(selection)


def _follow_live_input(panel: LiveInputPanel, session: SessionHost, selection: TaxelSelection) -> None:
    _follow_connection(panel, session, selection)
    session.reading_changed.connect(panel.show_reading)
    panel.reading_edited.connect(session.set_reading)


def _follow_simulated_skin(panel: SimulatedSkinPanel, session: SessionHost, selection: TaxelSelection) -> None:
    _follow_connection(panel, session, selection)
    comparison = session.skin_comparison
    comparison.compared.connect(panel.show_difference)
    comparison.failed.connect(panel.show_refusal)
    panel.enabled_changed.connect(comparison.set_enabled)


def _follow_quality(panel: QualityPanel, session: SessionHost, _selection: TaxelSelection) -> None:
    session.measurements.measured.connect(panel.show_quality)


def _make_compare(editor: MapEditor, panels: Panels) -> ComparePanel:
    """Construct the panel, whose results are shown in the quality card."""
    panel = ComparePanel(editor)
    quality = panels.get(QualityPanel)
    panel.compared.connect(quality.show_comparison)
    panel.ended.connect(quality.end_comparison)
    return panel


PANELS = (
    PanelSpec(PanelTab.LIVE, lambda *_: LiveInputPanel(), GuidePlace("live"), _follow_live_input),
    PanelSpec(
        PanelTab.LIVE,
        lambda *_: SkinCheckPanel(),
        GuidePlace("live", "Checking a skin"),
        _follow_connection,
        folded_at_first=True,
    ),
    PanelSpec(
        PanelTab.LIVE,
        lambda editor, _: SimulatedSkinPanel(editor),
        GuidePlace("live", "Comparing with a simulation"),
        _follow_simulated_skin,
        folded_at_first=True,
    ),
    PanelSpec(
        PanelTab.LIVE,
        lambda *_: RequestedMotionPanel(),
        GuidePlace("live", "Motion for the real robot"),
        _follow_connection,
        folded_at_first=True,
    ),
    PanelSpec(PanelTab.TOUCH, lambda *_: ContactsPanel(), GuidePlace("control", "Contacts"), _follow_contacts),
    PanelSpec(PanelTab.TOUCH, lambda *_: EventsPanel(), GuidePlace("control", "Contacts")),
    PanelSpec(PanelTab.CONTROL, lambda *_: ControllerPanel(), GuidePlace("control", "Controllers"), _follow_controller),
    PanelSpec(
        PanelTab.CONTROL,
        lambda *_: BehavioursPanel(),
        GuidePlace("control", "Contacts"),
        _follow_behaviours,
        folded_at_first=True,
    ),
    PanelSpec(PanelTab.CONTROL, lambda *_: PosturePanel(), GuidePlace("control", "Posture"), folded_at_first=True),
    PanelSpec(PanelTab.MAP, lambda editor, _: PatchesPanel(editor), GuidePlace("maps", "Editing a map")),
    PanelSpec(PanelTab.MAP, lambda *_: QualityPanel(), GuidePlace("maps", "Map quality"), _follow_quality),
    PanelSpec(PanelTab.MAP, _make_compare, GuidePlace("maps", "Map quality"), folded_at_first=True),
    PanelSpec(PanelTab.MAP, lambda editor, _: HistoryPanel(editor), GuidePlace("maps", "Editing a map")),
    PanelSpec(PanelTab.MODEL, lambda *_: SkinPanel(), GuidePlace("maps", "Choosing the skin")),
    PanelSpec(PanelTab.MODEL, lambda *_: EffectsPanel(), GuidePlace("touch")),
    PanelSpec(PanelTab.MODEL, lambda *_: TimingPanel(), GuidePlace("measurements", "Speed of the simulation")),
    PanelSpec(PanelTab.MODEL, lambda *_: AccuracyPanel(), GuidePlace("studies", "In the window"), folded_at_first=True),
    PanelSpec(PanelTab.MODEL, lambda *_: FindingsPanel(), GuidePlace("sessions", "The window")),
    PanelSpec(PanelTab.MODEL, lambda *_: MessagesPanel(), GuidePlace("sessions", "The window"), folded_at_first=True),
)
"""All panels, tab by tab and from top to bottom."""
