"""What a force loop through the skin can hold, worked out at run time.

``contact_stiffness`` measures how stiff what touches is, ``pressed_arm`` is the linear model of an arm that presses on
it, with its greatest stable gain, and ``gain_limits`` holds a controller's gains to a share of that. ``loop_stability``
knows the skin's times and the signs of a loop that swings.
"""
