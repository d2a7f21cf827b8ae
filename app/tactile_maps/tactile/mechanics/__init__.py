"""Mechanics of an elastic skin.

``loads``              bodies that press, and their load on a link at one instant
``broadphase``         points of skin and bare link near a body
``elastic_layer``      material and stiffness of the cover
``winkler``            depth and tilt of a body on a bed of springs
``half_space_stress``  normal stress below the surface
``receptive_field``    stress that each taxel measures
``contact_notes``      deviations of a model from what was requested
"""
