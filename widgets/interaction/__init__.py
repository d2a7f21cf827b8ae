"""What the mouse and the keys mean on a view, the same for robot and map.

``poke_gesture`` and ``select_gesture`` are state machines without Qt (the second with its adapter to Qt's events),
``view_tool`` is what a view asks of a tool, ``polyline`` makes few corners of a stroke.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
