"""Stability of a force loop through the skin, computed at run time.

``contact_stiffness``  stiffness of a contact, measured while the arm approaches
``pressed_arm``        linear model of an arm that presses a spring, with its largest stable gain
``sampled_loop``       stability limits of ideal joints on a spring, in closed form
``loop_stability``     times of the skin's readings, and detection of oscillations
``normal_motion``      how well the joints move a point along its normal
"""
