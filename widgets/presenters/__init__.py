"""What connects actions, views, panels, session and document; each presenter owns one topic and decides who asks whom.

``linked_views`` keeps robot and map in step: one hover, one selection, one scale. ``file_presenter`` opens and saves
robots, scenes and recordings, ``map_file_presenter`` the map being edited. ``view_presenter`` takes tools, selection
and overlays to the views; ``map_edit_presenter`` is the Edit menu, ``control_presenter`` the Control menu,
``comparison_presenter`` the comparison of controllers, ``touch_script_presenter`` the Touch menu, ``effects_presenter``
what is simulated. ``notification_presenter`` says what failed, stopped or was saved.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
