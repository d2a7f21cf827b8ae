"""The window: everything that users see or touch.

``window``      the application and its main window, which only connects parts
``context``     what every presenter receives instead of the window: sessions, documents, views, notifications
``presenters``  connect actions, views and panels with session and document, one topic each
``actions``     menus, keys, icons and their state
``views``       views of the robot (``robot``) and of its map (``map``), which do not know each other, and their layers
``panels``      panels next to the views
``plots``       plots, timeline, work-precision diagrams
``tools``       tools for paths, targets and map editing
``dialogs``     dialogs
``session``     the only code that changes the running session
``document``    the only code that changes the map being edited
``jobs``        work in the background, in processes or inline
``overlays``    marks of taxel faults
``common``      colours, themes, settings, small widgets

Each extension has one place:

========== ================================= =========================================================================
extension  place                             what follows from it
========== ================================= =========================================================================
an action  ``actions.table``, one entry      its menu, key, tip, button and icon, the list of keys, enabled, checked
a tool     ``tools.registry``, one entry     all of the above, and presses, keys and wheel of both views
a panel    ``panels.registry``, one entry    its place, scenes, frames, theme, session, whether it is folded
a layer    ``views.layers``, one entry       its action and setting; edits, frames and theme, on the map and on the body
========== ================================= =========================================================================

A presenter connects an action to its function (``context.actions.bind``). A tool or a panel is a class in a file of its
own, which its entry names; the same holds for what a layer draws on the map and on the body.
"""
