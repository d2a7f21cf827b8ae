"""Actions of the window: menus, shortcuts and toolbar buttons.

``table`` defines the menu bar with all actions. ``state`` holds the state that enables actions, and the rules;
``registry`` makes the Qt actions, fills the menu bar and applies a state; ``focused_keys`` leaves keys to the focused
control; ``icons`` draws the icons of the toolbar.
"""
