"""Everything a person can ask of the window by menu, key or button.

``table`` is the menu bar with each action where it stands: the one place of an action. ``state`` is what depends on the
window, with the rules that enable; ``registry`` makes the actions and shows a state, ``menus`` fills the menu bar,
``focused_keys`` leaves keys to the control that has the focus, ``icons`` draws the few of the toolbar.
"""
