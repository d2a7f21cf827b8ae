"""The session as the window has it. ``live_session`` is the only caller that changes it, and tells what becomes of it.

It is put together from parts: ``live_run`` has the two things it can show, a scene that runs and a recording that is
replayed; ``live_input`` lets readings of a real skin run instead of a simulation;
``session_runner`` drives the first, by the wall clock on a thread or when told to; ``recording_writer``
writes its ticks to a file on a thread of its own; ``active_settings`` tells settings, effects, behaviours and reading
in force, once a change; ``measurements`` asks the measuring processes about what is shown, and drops what comes late.
``backends`` says what does the work: a thread and processes beside the window, or all of it
inline.
"""
