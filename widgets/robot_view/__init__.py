"""The robot in three dimensions, its skin coloured by pressure, and the gestures on it.

Read in this order: ``robot_view`` is the Qt widget: gestures, turned into pokes, selections, edits and camera moves,
and the slider that lays the skin flat. It holds a ``robot_display``, what is drawn: the newest frame when it is due, on
one of the two kinds of ``plotter_widget``, under a ``caption_overlay`` with the orientation cube. ``robot_scene`` draws
on any PyVista plotter and knows no Qt: ``skin_actors``, ``object_actors``, ``contact_marks`` and
``tool_and_task_marks``, all by the meshes of ``surface_marks``; over them the ``body_layers`` of View > Overlay.
``camera`` and ``picking`` are arithmetic: pixel to ray, ray to skin, and the camera moved by hand.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
