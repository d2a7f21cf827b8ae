"""What the live session tells whoever shows it: facts, as signals. What a hand wants goes in by methods instead."""

from __future__ import annotations

from PySide6.QtCore import QObject, Signal


class SessionSignals(QObject):
    """Past-tense changes of the session; none asks for an answer."""

    frame_ready = Signal(object)
    """The newest Frame, at most once a drawn frame; live or replayed."""
    prepared_changed = Signal(object)
    """Another Prepared is shown from now on."""
    map_changed = Signal(object)
    """The TactileMap in force in what is replayed: a recorded edit was passed."""
    measured = Signal(object)
    """The MapQuality of its map."""
    loading = Signal(str, float)
    """A scene is being prepared: the stage, and 0 to 1."""
    loading_ended = Signal()
    """It is not any more: done, failed or cancelled."""
    failed = Signal(str)
    """Something could not be done; the sentence says what, where and what helps. All that was good is kept."""
    halted = Signal(str)
    """The simulation failed and stands still; the sentence says why. ``reset`` starts it again."""
    mode_changed = Signal(str)
    """``empty``, ``live``, ``paused`` or ``replaying``."""
    recording_changed = Signal(object)
    """Path of the recording being written, or None."""
    saved = Signal(str)
    """Path of a complete recording."""
    player_changed = Signal(object)
    """The Player being replayed, or None."""
    settings_changed = Signal(object)
    """ControlSettings in force."""
    effects_changed = Signal(object)
    """Effects in force."""
    reading_changed = Signal(object)
    """ReadingSettings in force."""
    behaviours_changed = Signal(object)
    """The tuple of Behaviour in force."""
    triggered = Signal(str)
    """A behaviour changed the controller: the event that did it, in words."""
    touched = Signal()
    """A person touched the skin."""
