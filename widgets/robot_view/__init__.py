"""The robot in three dimensions, its skin coloured by pressure, and the gestures on it.

Read in this order: ``robot_view`` turns gestures into pokes, selections, edits and camera moves; ``robot_display`` says
what is missing and lays the skin flat; ``robot_canvas`` draws the newest frame when it is due, on one of the two kinds
of ``plotter_widget``, under a ``caption_overlay`` with the orientation cube. ``robot_scene`` draws on any PyVista
plotter and knows no Qt: ``skin_actors``, ``object_actors``, ``contact_marks``, ``tool_and_task_marks`` (shaped by
``surface_marks``) on ``vtk_meshes``. ``camera`` and ``picking`` are arithmetic: pixel to ray, ray to skin, and the
camera moved by hand.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
