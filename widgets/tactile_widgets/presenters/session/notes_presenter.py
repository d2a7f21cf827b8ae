"""Notes on recordings: marks, set during recording or replay, the range, and episodes."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from itertools import pairwise

from PySide6.QtCore import QPoint
from PySide6.QtWidgets import QMenu, QWidget

from tactile_maps.recording.encoding.annotations import LabelledEpisode, Mark
from tactile_maps.recording.player import RecordingPlayer
from tactile_widgets.common.make import DELETED_ON_CLOSE, add_entry, make
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.context.presenter import Presenter
from tactile_widgets.dialogs.episode_dialog import EpisodeDialog
from tactile_widgets.plots.timeline.playhead import Span, clock_text
from tactile_widgets.plots.timeline.scrub_bar import TimelineNotes
from tactile_widgets.plots.traces.history import EventHistory
from tactile_widgets.tools.registry import Tools

_NEAR_SHARE = 0.008
"""Maximum distance of a mark from the pointer on the timeline, as a share of the recording."""


class NotesPresenter(Presenter):
    """Implements marks, range and episodes of the menu Recording, and the context menu of the timeline.

    Args:
        context: Session, views, panels and services of the window.
        tools: Tools whose undo applies to the notes while a recording is shown.
        parent: Window over which dialogs open.
    """

    def __init__(self, context: AppContext, tools: Tools, parent: QWidget) -> None:
        super().__init__(context, parent)
        self._tools = tools
        self._timeline = context.timeline
        self._notes = context.notes
        self.menu: QMenu | None = None
        self.dialog: EpisodeDialog | None = None
        context.actions.bind(
            mark=self.mark,
            name_mark=self.name_mark,
            delete_mark=self.delete_mark,
            previous_mark=partial(self.jump, -1),
            next_mark=partial(self.jump, 1),
            range_start=self.start_range,
            range_end=self.end_range,
            clear_range=self.clear_range,
            loop=self.toggle_loop,
            label_episode=self.label_range,
            split_episodes=self.split,
            delete_episode=self.delete_episode,
        )
        self._timeline.menu_requested.connect(self.open_menu)
        self._session.replay.player_changed.connect(self._on_player_changed)
        self._notes.changed.connect(self._on_notes_changed)
        self._notes.failed.connect(partial(context.notifier.fault, of="save notes"))
        self._notes.changed.connect(partial(context.notifier.succeed, "save notes"))

    @property
    def _tick(self) -> int:
        """Tick that is shown."""
        frame = self._session.shown
        return 0 if frame is None else frame.tick

    # Marks.

    def mark(self) -> None:
        """Mark the current time with a numbered name."""
        if self._session.replay.player is None:
            self._session.recording.mark(f"Mark {self._session.recording.marks + 1}")
        else:
            self._set_mark(Mark(self._tick, f"Mark {len(self._notes.value.marks) + 1}"))

    def name_mark(self) -> None:
        """Ask for a name, and mark the current time."""
        tick = self._tick
        known = self._mark_here()
        live = self._session.replay.player is None

        def named(name: str) -> None:
            if live:
                self._session.recording.mark(name, tick)
            elif self._notes.editable:
                self._set_mark(Mark(tick, name))

        self._context.dialogs.ask_text("mark-name", "Name mark", "Name", named, value=known.name if known else "")

    def _set_mark(self, mark: Mark) -> None:
        self._notes.edit("Mark", self._notes.value.with_mark(mark))

    def _mark_here(self) -> Mark | None:
        return next((mark for mark in self._notes.value.marks if mark.tick == self._tick), None)

    def delete_mark(self) -> None:
        """Delete the mark at the current time."""
        if (mark := self._mark_here()) is None:
            self._notifier.status("No mark here; go to one first")
        else:
            self._notes.edit("Delete mark", self._notes.value.without_mark(mark))

    def jump(self, direction: int) -> None:
        """Go to the next mark (1) or the one before (-1)."""
        ticks = [mark.tick for mark in self._notes.value.marks]
        ahead = [tick for tick in ticks if (tick - self._tick) * direction > 0]
        if ahead and (player := self._session.replay.player) is not None:
            self._timeline.go_to(player.seconds_at(min(ahead, key=lambda tick: abs(tick - self._tick))))

    # The range.

    def start_range(self) -> None:
        """Begin the range at the current time."""
        self._put_range(start=self._timeline.playhead.time)

    def end_range(self) -> None:
        """End the range at the current time."""
        self._put_range(end=self._timeline.playhead.time)

    def _put_range(self, *, start: float | None = None, end: float | None = None) -> None:
        """Move one end of the range; the other end moves to the end of the recording if they would cross."""
        whole = Span(0.0, self._timeline.playhead.duration)
        old = self._timeline.range or whole
        first = old.start if start is None else start
        last = old.end if end is None else end
        if start is not None and start >= last:
            last = whole.end
        if end is not None and end <= first:
            first = whole.start
        self._timeline.set_range(Span.between(first, last))

    def clear_range(self) -> None:
        """Remove the range."""
        self._timeline.set_range(None)

    def toggle_loop(self) -> None:
        """Toggle playing the range repeatedly."""
        on = self._timeline.playhead.loop is None
        self._timeline.set_loop(on=on)
        if on and not self._timeline.playhead.playing:
            self._timeline.toggle_play()

    # Episodes.

    def label_range(self) -> None:
        """Ask for a label, and store the range as an episode."""
        player = self._session.replay.player
        chosen = self._timeline.range
        if player is not None and chosen is not None:
            number = len(self._notes.value.episodes) + 1
            first = player.tick_at(chosen.start)
            last = player.tick_at(chosen.end)
            self._ask(LabelledEpisode(first, last, f"Episode {number}"), "Add episode")

    def _ask(self, episode: LabelledEpisode, step: str) -> None:
        dialog = self.dialog = EpisodeDialog(episode, self._window)
        dialog.chosen.connect(lambda named: self._notes.edit(step, self._notes.value.with_episode(named)))
        dialog.open()

    def split(self) -> None:
        """Make episodes of the parts between marks, named after their first mark."""
        player = self._session.replay.player
        notes = self._notes.value
        if player is None:
            return
        tick = player.prepared.scene.tick
        first = round(float(player.times[0]) / tick)
        last = round(float(player.times[-1]) / tick)
        names = {first: "Start"} | {mark.tick: mark.name for mark in notes.marks if mark.tick < last}
        for start, after in pairwise([*sorted(names), last + 1]):
            notes = notes.with_episode(LabelledEpisode(start, after - 1, names[start]))
        self._notes.edit("Split into episodes", notes)

    def episode_at(self, tick: int) -> LabelledEpisode | None:
        """Return the shortest episode that contains a tick."""
        around = [one for one in self._notes.value.episodes if one.first <= tick <= one.last]
        return min(around, key=lambda one: one.last - one.first, default=None)

    def delete_episode(self) -> None:
        """Delete the episode at the current time; the recording keeps its data."""
        if (episode := self.episode_at(self._tick)) is None:
            self._notifier.status("No episode here; go to one first")
        else:
            self._notes.edit("Delete episode", self._notes.value.without_episode(episode))

    # The timeline.

    def _on_player_changed(self, player: RecordingPlayer | None) -> None:
        self._tools.lend_undo(None if player is None else self._notes)
        if player is None:
            self._notes.close()
        else:
            self._notes.open(player)

    def _on_notes_changed(self) -> None:
        self._tools.undo_changed.emit()
        if (player := self._session.replay.player) is not None:
            at = player.seconds_at
            notes = self._notes.value
            marks = tuple((at(mark.tick), mark.name) for mark in notes.marks)
            episodes = tuple((at(one.first), at(one.last + 1), episode_words(one)) for one in notes.episodes)
            self._timeline.show_notes(TimelineNotes(marks, episodes, slips_of(player)))

    def open_menu(self, time: float, place: QPoint) -> None:
        """Open the context menu for a time of the recording that is shown or being written."""
        menu = self.menu = make(QMenu, self._window, objectName="timeline-menu", attribute=DELETED_ON_CLOSE)
        if (player := self._session.replay.player) is None:
            for name in ("record", "mark", "name_mark"):
                menu.addAction(self._context.actions[name])
            menu.popup(place)
            return

        offer = partial(add_entry, menu)

        def there(act: Callable[[], None]) -> Callable[[], None]:
            def go_and_act() -> None:
                self._timeline.go_to(time)
                act()

            return go_and_act

        near = self._near(time, player)
        offer(f"Go to {clock_text(time, decimals=2)}", there(lambda: None))
        if near is not None:
            time = player.seconds_at(near.tick)
            offer(f"Name {near.name}…", there(self.name_mark))
            offer(f"Delete {near.name}", there(self.delete_mark))
        elif self._notes.editable:
            offer("Mark here", there(self.mark))
            offer("Mark here with a name…", there(self.name_mark))
        menu.addSeparator()
        offer("Begin the range here", there(self.start_range))
        offer("End the range here", there(self.end_range))
        if (episode := self.episode_at(player.tick_at(time))) is not None:
            menu.addSeparator()
            offer(f"Choose {episode.label} as the range", partial(self._choose, episode))
            offer(f"Edit {episode.label}…", partial(self._ask, episode, "Edit episode"))
            offer(f"Delete {episode.label}", there(self.delete_episode))
        if self._timeline.range is not None:
            menu.addSeparator()
            for name in ("loop", "trim_range", "label_episode", "clear_range"):
                menu.addAction(self._context.actions[name])
        menu.popup(place)

    def _choose(self, episode: LabelledEpisode) -> None:
        if (player := self._session.replay.player) is not None:
            start = player.seconds_at(episode.first)
            end = player.seconds_at(episode.last)
            self._timeline.set_range(Span.between(start, end))

    def _near(self, time: float, player: RecordingPlayer) -> Mark | None:
        """Return the mark under the pointer."""
        reach = _NEAR_SHARE * player.duration
        marks = [mark for mark in self._notes.value.marks if abs(player.seconds_at(mark.tick) - time) <= reach]
        return min(marks, key=lambda mark: abs(player.seconds_at(mark.tick) - time), default=None)


def episode_words(episode: LabelledEpisode) -> str:
    """Return label and outcome of an episode."""
    return episode.label if episode.outcome is None else f"{episode.label} ({episode.outcome})"


_SLIPS = {"incipient-slip": "Slip begins at the border", "slip": "Slips"}


def slips_of(player: RecordingPlayer) -> tuple[tuple[float, float, str], ...]:
    """Return start and end [s from the first frame] and text of each slip in a recording, by kind and start."""
    history = EventHistory(seconds=math.inf)
    history.take(float(player.times[-1]), player.events[::-1])
    end = player.duration
    return tuple(
        (max(end + start, 0.0), end + last, _SLIPS[kind])
        for kind, spans in history.rows
        if kind in _SLIPS
        for start, last in spans
        if end + last >= 0
    )
