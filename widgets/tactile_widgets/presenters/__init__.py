"""What connects actions, views, panels, session and document; each presenter owns one topic and decides who asks whom.

A presenter is given an ``AppContext`` and never the window; ``composition`` makes them in one acyclic order.
``state_tracker`` keeps the actions as the window's state has them; ``view_presenter`` is the menus Select and View,
``map_edit_presenter`` Edit; ``notification_presenter`` says what failed, stopped or was saved.

``files``    opening and saving, the file of the map being edited, exports
``session``  scenes and frames handed on, the menu Session and a real skin's readings, the script of touches, the panels
             *Effects* and *Accuracy and time*
``control``  the menu Control, the comparison of laws
"""
