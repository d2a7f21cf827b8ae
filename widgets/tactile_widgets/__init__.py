"""Everything a user sees or touches.

``window`` opens it and puts it together; ``presenters`` connect what is shown to what is done, each one topic, given an
``AppContext`` and never the window. Two owners of change stand behind them: ``session`` is the only caller that changes
what runs, ``document`` the only one that changes the map being edited; ``workers`` are the processes beside.
``robot_view`` draws the body, ``map_view`` the map; they never know of each other.

To add something is one place:

========== ================================= =========================================================================
what       where                             what follows from it
========== ================================= =========================================================================
an action  ``actions.table``, one entry      its menu, key, tip, button and icon, the list of keys, enabled, checked
a tool     ``tools.registry``, one entry     all of the above, and presses, keys and wheel of both views
a panel    ``panels.registry``, one entry    its place, scenes, frames, theme, session, whether it is folded
a layer    ``layers.registry``, one entry    its action and setting; edits, frames and theme, on the map and on the body
========== ================================= =========================================================================

What an action does is bound by a presenter (``context.actions.bind``); a tool or a panel is a class in a file of its
own, named in its entry; so is what a layer draws on either side.
"""
