"""Creation of the presenters in an acyclic order, each with the presenters that it uses."""

from __future__ import annotations

from PySide6.QtWidgets import QWidget

from tactile_widgets.context.app_context import AppContext
from tactile_widgets.presenters.control.comparison_presenter import ComparisonPresenter
from tactile_widgets.presenters.control.control_presenter import ControlPresenter, ControlToolsPresenter
from tactile_widgets.presenters.control.posture_presenter import PosturePresenter
from tactile_widgets.presenters.files.arrival_presenter import ArrivalPresenter
from tactile_widgets.presenters.files.export_presenter import ExportPresenter
from tactile_widgets.presenters.files.figure_presenter import FigurePresenter
from tactile_widgets.presenters.files.file_presenter import FilePresenter
from tactile_widgets.presenters.files.film_presenter import FilmPresenter
from tactile_widgets.presenters.files.recordings_presenter import RecordingsPresenter
from tactile_widgets.presenters.files.skin_presenter import SkinPresenter
from tactile_widgets.presenters.files.study_presenter import StudyPresenter
from tactile_widgets.presenters.files.unsaved_presenter import UnsavedPresenter
from tactile_widgets.presenters.maps.map_edit_presenter import MapEditPresenter
from tactile_widgets.presenters.maps.map_file_presenter import MapFilePresenter
from tactile_widgets.presenters.maps.scene_file_presenter import SceneFilePresenter
from tactile_widgets.presenters.notification_presenter import NotificationPresenter
from tactile_widgets.presenters.plots_presenter import PlotsPresenter
from tactile_widgets.presenters.pointing_presenter import PointingPresenter
from tactile_widgets.presenters.preferences_presenter import PreferencesPresenter
from tactile_widgets.presenters.session.accuracy_presenter import AccuracyPresenter
from tactile_widgets.presenters.session.effects_presenter import EffectsPresenter
from tactile_widgets.presenters.session.faults_presenter import FaultsPresenter
from tactile_widgets.presenters.session.notes_presenter import NotesPresenter
from tactile_widgets.presenters.session.overlay_presenter import OverlayPresenter
from tactile_widgets.presenters.session.recording_plots_presenter import RecordingPlotsPresenter
from tactile_widgets.presenters.session.replay_past import ReplayPast
from tactile_widgets.presenters.session.scene_presenter import ScenePresenter
from tactile_widgets.presenters.session.session_presenter import LiveInputPresenter, SessionPresenter
from tactile_widgets.presenters.session.touch_script_presenter import TouchScriptPresenter
from tactile_widgets.presenters.state_tracker import StateTracker
from tactile_widgets.presenters.touch_presenter import TouchPresenter
from tactile_widgets.presenters.view_presenter import ViewPresenter
from tactile_widgets.tools.registry import Tools


class Presenters:
    """All presenters of a window, and the tools that they share.

    Args:
        context: Session, views, panels and services of the window.
        parent: The window, which owns the presenters.
    """

    def __init__(self, context: AppContext, parent: QWidget) -> None:
        tools = self.tools = Tools(context.editor, parent)
        effects = self.effects = EffectsPresenter(context, parent)
        self.scene_file = SceneFilePresenter(context, effects, parent)
        self.map_files = MapFilePresenter(context, self.scene_file, tools, parent)
        self.map_edit = MapEditPresenter(context, tools, self.map_files, parent)
        self.arrivals = ArrivalPresenter(context, self.map_files, tools, parent)
        self.studies = StudyPresenter(context, parent)
        self.files = FilePresenter(context, effects, self.map_files, self.scene_file, self.studies, tools, parent)
        self.unsaved = UnsavedPresenter(context, self.map_files, self.files, parent)
        self.skin = SkinPresenter(context, effects, self.map_files, self.files, tools, parent)
        self.plots = PlotsPresenter(context, parent)
        self.figure = FigurePresenter(context, parent)
        self.overlay = OverlayPresenter(context, parent)
        self.touch = TouchPresenter(context, parent)
        self.faults = FaultsPresenter(context, parent)
        self.recordings = RecordingsPresenter(context, self.files, self.overlay, parent)
        self.export = ExportPresenter(context, parent)
        self.live_input = LiveInputPresenter(context, self.map_files, parent)
        self.view = ViewPresenter(context, tools, parent)
        self.session = SessionPresenter(context, parent)
        self.recording_plots = RecordingPlotsPresenter(context, parent)
        self.notes = NotesPresenter(context, tools, parent)
        self.replay_past = ReplayPast(context, parent)
        self.notification = NotificationPresenter(context, self.touch, parent)
        self.film = FilmPresenter(context, parent)
        self.pointing = PointingPresenter(context, tools, self.touch, self.plots, self.figure, self.skin, parent)
        self.preferences = PreferencesPresenter(context, parent)
        self.touch_script = TouchScriptPresenter(context, effects, parent)
        self.control_tools = ControlToolsPresenter(context, tools, parent)
        self.control = ControlPresenter(context, parent)
        self.posture = PosturePresenter(context, tools, parent)
        self.comparison = ComparisonPresenter(context, effects, parent)
        self.accuracy = AccuracyPresenter(context, effects, parent)
        self.scene = ScenePresenter(context, effects, self.map_edit, parent)
        self.state = StateTracker(context, tools, self.overlay, self.map_files, self.unsaved, parent)

    def close(self) -> None:
        """Complete files and end background work."""
        for presenter in (
            self.arrivals,
            self.export,
            self.map_files,
            self.skin,
            self.accuracy,
            self.comparison,
            self.session,
            self.replay_past,
            self.recording_plots,
            self.recordings,
            self.studies,
            self.plots,
            self.film,
            self.overlay,
        ):
            presenter.close()
