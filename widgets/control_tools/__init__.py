"""The tools that tell the arm where to go: a path or a target drawn on map or body, and the force there.

``path_shape`` knows a path's handles and what dragging one does, ``path_sketch`` a path while it is drawn; ``wishes``
remembers what can be taken back, and ``lead`` is whom the tools ask for settings. ``path_tool``, ``target_tool`` and
the ``force_plate`` that both carry are what a person takes; ``drawing`` is how they look.
"""
