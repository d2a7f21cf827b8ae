"""The panels, one line each, in the order of the column: what makes a panel, and what of the session it follows.

What is touched and what the arm does are at the top, then the map, from what is edited to how good that is, then what
it all costs, and what was noticed and said.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
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
from tactile_widgets.panels.model.timing_panel import TimingPanel
from tactile_widgets.panels.note_list import FindingsPanel, MessagesPanel
from tactile_widgets.panels.touch.contacts_panel import ContactsPanel
from tactile_widgets.panels.touch.events_panel import EventsPanel
from tactile_widgets.panels.touch.live_input_panel import LiveInputPanel
from tactile_widgets.panels.touch.requested_motion_panel import RequestedMotionPanel
from tactile_widgets.panels.touch.simulated_skin_panel import SimulatedSkinPanel
from tactile_widgets.session.session_host import SessionHost

P = TypeVar("P", bound=Panel)


class Panels(Protocol):
    """The panels made so far."""

    def get(self, kind: type[P]) -> P:
        """The panel of a class."""


Make = Callable[[MapEditor, Panels], Panel]
Follow = Callable[[Any, SessionHost, TaxelSelection], None]


@dataclass(frozen=True)
class PanelSpec:
    """One panel.

    Attributes:
        make: Makes it for a map's editor; it may connect itself to those above it.
        follow: Connects the panel, first argument, to session and selection; scenes and frames come by the hooks of
            ``Panel``. None where it follows neither.
        folded_at_first: Whether a person looks for it only when it is needed.
        guide: Where the guide says what it is.
    """

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


def _follow_live_input(panel: LiveInputPanel, session: SessionHost, selection: TaxelSelection) -> None:
    session.connection.changed.connect(panel.show_input)
    panel.follow(selection)


def _follow_simulated_skin(panel: SimulatedSkinPanel, session: SessionHost, selection: TaxelSelection) -> None:
    session.connection.changed.connect(panel.show_input)
    comparison = session.skin_comparison
    comparison.compared.connect(panel.show_difference)
    comparison.failed.connect(panel.show_refusal)
    panel.wanted.connect(comparison.set_wanted)
    panel.follow(selection)


def _follow_requested_motion(panel: RequestedMotionPanel, session: SessionHost, _selection: TaxelSelection) -> None:
    session.connection.changed.connect(panel.show_input)


def _follow_quality(panel: QualityPanel, session: SessionHost, _selection: TaxelSelection) -> None:
    session.measurements.measured.connect(panel.show_quality)


def _make_compare(editor: MapEditor, panels: Panels) -> ComparePanel:
    """What it finds is shown in the quality card."""
    panel = ComparePanel(editor)
    quality = panels.get(QualityPanel)
    panel.compared.connect(quality.show_comparison)
    panel.ended.connect(quality.end_comparison)
    return panel


PANELS = (
    PanelSpec(lambda _editor, _panels: LiveInputPanel(), GuidePlace("live"), _follow_live_input),
    PanelSpec(
        lambda editor, _panels: SimulatedSkinPanel(editor),
        GuidePlace("live", "Comparing with a simulation"),
        _follow_simulated_skin,
        folded_at_first=True,
    ),
    PanelSpec(
        lambda _editor, _panels: RequestedMotionPanel(),
        GuidePlace("live", "Motion for the real robot"),
        _follow_requested_motion,
        folded_at_first=True,
    ),
    PanelSpec(lambda _editor, _panels: ContactsPanel(), GuidePlace("control", "Contacts"), _follow_contacts),
    PanelSpec(lambda _editor, _panels: ControllerPanel(), GuidePlace("control", "Controllers"), _follow_controller),
    PanelSpec(lambda _editor, _panels: EventsPanel(), GuidePlace("control", "Contacts")),
    PanelSpec(
        lambda _editor, _panels: BehavioursPanel(),
        GuidePlace("control", "Contacts"),
        _follow_behaviours,
        folded_at_first=True,
    ),
    PanelSpec(lambda _editor, _panels: PosturePanel(), GuidePlace("control", "Posture"), folded_at_first=True),
    PanelSpec(lambda editor, _panels: PatchesPanel(editor), GuidePlace("maps", "Editing a map")),
    PanelSpec(lambda _editor, _panels: QualityPanel(), GuidePlace("maps", "Map quality"), _follow_quality),
    PanelSpec(_make_compare, GuidePlace("maps", "Map quality"), folded_at_first=True),
    PanelSpec(lambda editor, _panels: HistoryPanel(editor), GuidePlace("maps", "Editing a map"), folded_at_first=True),
    PanelSpec(lambda _editor, _panels: AccuracyPanel(), GuidePlace("studies", "In the window"), folded_at_first=True),
    PanelSpec(lambda _editor, _panels: TimingPanel(), GuidePlace("measurements", "Speed of the simulation")),
    PanelSpec(lambda _editor, _panels: EffectsPanel(), GuidePlace("touch")),
    PanelSpec(lambda _editor, _panels: FindingsPanel(), GuidePlace("sessions", "The window")),
    PanelSpec(lambda _editor, _panels: MessagesPanel(), GuidePlace("sessions", "The window"), folded_at_first=True),
)
"""One line a panel: its place in the column, and all that reaches it, come from here."""
