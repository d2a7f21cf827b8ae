"""Physics of the robot, of the objects around it and of the fingers that press it, and what its skin reads of that.

- ``simulation``: the whole, with fingers, sensor and effects that change while it runs.
- ``physics``: one compiled model at work: its steps and what acts between them.
- ``model``: a MuJoCo model of exactly the effects that are on: objects, contact pairs, stiffness.
- ``fingers``: springs that press the skin.
- ``pressing_shapes``: the solid shapes that may press.
- ``contact_loads``: what contacts do to skin and links.
- ``step_checks``: divergence, tunnelling, commands.
- ``known_load_check``: a known weight laid on the skin.
"""
