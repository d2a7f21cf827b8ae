"""Everything a person can ask of the window by menu, key or button.

``registry`` is the table of actions and makes them, with their shortcuts and the list of keys; ``menus`` arranges them;
``icons`` draws the few that the toolbar shows.
"""
