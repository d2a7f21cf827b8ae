"""What is being recorded, and recordings to play, scrub and step through.

``playhead`` is the rule of where a replay stands, without Qt; ``scrub_bar`` draws it with what happened and what was
said of it; ``timeline`` adds buttons and keys. ``recording_plots`` shows curves over the whole: its ``lanes`` say
which, and ``lane_painter`` draws them.
Neither reads a clock: whoever plays passes the elapsed time in.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
