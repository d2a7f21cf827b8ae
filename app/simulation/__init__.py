"""Physics of the robot, of the objects around it and of the fingers that press it, and what its skin reads of that.

- ``simulation``: the whole, with fingers, sensor and effects that change while it runs.
- ``physics``: one compiled model at work: its steps and what acts between them.
- ``model_assembly``: a MuJoCo model of exactly the effects that are on.
- ``object_geoms``: the scene's objects in it; ``model_names``: names of what is added to the robot.
- ``contact_pairs``: who may touch whom; ``contact_stiffness``: how stiff that is.
- ``fingers``: springs that press the skin.
- ``pressing_shapes``: the solid shapes that may press.
- ``contact_loads``: what contacts do to skin and links.
- ``step_checks``: divergence, tunnelling, commands.
- ``known_load_check``: a known weight laid on the skin.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
