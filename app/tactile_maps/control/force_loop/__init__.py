"""Stability of a force loop through the skin, computed at run time.

``contact_stiffness``  stiffness of a contact, measured while the arm approaches
``pressed_arm``        linear model of an arm that presses a spring, with its largest stable gain
``loop_stability``     times of the skin's readings, and signs of an oscillating loop
``normal_motion``      how well the joints move a point along its normal
"""
