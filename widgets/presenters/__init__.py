"""What connects actions, views, panels, session and document; each presenter owns one topic and decides who asks whom.

A presenter is given an ``AppContext`` and never the window; ``composition`` makes them in one acyclic order.
``scene_presenter`` receives scenes and frames and hands them on; ``state_tracker`` keeps the actions as the window's
state has them. ``file_presenter`` opens and saves,
``map_file_presenter`` keeps the map being edited;
``view_presenter`` is the menus Select and View, ``map_edit_presenter`` Edit, ``session_presenter`` Session and a real
skin's readings,
``control_presenter`` and ``comparison_presenter`` Control, ``touch_script_presenter`` Touch; ``effects_presenter`` and
``accuracy_presenter`` are the panels of that name, and ``notification_presenter`` says what failed, stopped or was
saved.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
