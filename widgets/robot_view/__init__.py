"""The robot in three dimensions, its skin coloured by pressure, and the gestures on it.

Read in this order: ``robot_view`` is the Qt widget: gestures, turned into pokes, selections, edits and camera moves,
and the slider that lays the skin flat. It holds a ``robot_display``, what is drawn: the newest frame when it is due, on
one of the two kinds of ``plotter_widget``, under a ``caption_overlay`` with the orientation cube. ``second_view`` is
one more look at the same scene. What is drawn is in ``scene``, which knows no Qt. ``camera`` and ``picking`` are
arithmetic: pixel to ray, ray to skin, and the camera moved by hand.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
