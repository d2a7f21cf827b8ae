"""Contact models: from loads to taxel pressures. ``contact_model`` defines the protocol and lists the models.

In order of what they take into account:

``point``       force and place
``water_fill``  also the shape of the body
``punch``       also the moment
``half_space``  also the cover between surface and taxel
``foundation``  computes the force itself, from the depth of the body in an elastic layer
``depth``       MuJoCo's own tactile sensor, for comparison

``stated_errors`` contains the stated errors of each model.
"""
