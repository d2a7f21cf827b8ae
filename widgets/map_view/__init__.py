"""The tactile map on the screen, live while it is edited, and the gestures on it.

Read in this order: ``map_view`` is the Qt view: its camera and the gestures, turned into pokes, selections and edits.
It holds a ``map_display``, what is drawn: frames, states and overlays. ``map_coordinates`` knows where on the skin a
place of the view is, and the camera as a value. ``map_scene`` keeps one document ready to be drawn: its ``live_image``,
rebuilt only where a chart changed, its ``map_shapes``, the ``map_items`` in the scene, ``background`` and legend of an
overlay, ``taxel_faults`` and the marks of ``bijectivity``. ``foreground`` is what lies over the scene: View > Overlay
and the controller's task.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
