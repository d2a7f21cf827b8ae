"""Everything a person can ask of the window by menu, key or button.

``table`` is the menu bar with each action where it stands: the one place of an action. ``state`` is what depends on the
window, with the rules that enable; ``registry`` makes the actions, fills the menu bar and shows a state;
``focused_keys`` leaves keys to the control that has the focus, ``icons`` draws the few of the toolbar.
"""
