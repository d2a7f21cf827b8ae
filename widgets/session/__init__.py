"""The running session as the window has it. ``live_session`` is the only caller that changes it.

``session_signals`` lists the facts it tells; ``session_runner`` drives it, by the wall clock on a thread or when told
to; ``active_settings`` tells settings, effects, behaviours and reading in force, once a change; ``recording_writer``
writes ticks to a file. ``backends`` says what does the work: a thread and processes beside the window, or all of it
inline.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
