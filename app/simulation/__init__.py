"""Physics of the robot, of the things around it and of the fingers that press it, and what its skin reads of that.

``assemble`` compiles a model of exactly the effects that are on: ``object_geoms`` adds things, ``contact_pairs`` says
who may touch whom, ``real_stiffness`` how hard. ``physics`` steps it, ``simulation`` adds ``fingers`` and the sensor,
and ``carry_state`` takes the state along when effects change. ``contact_loads`` are what presses the skin at one
instant, by ``geom_shapes``, and ``link_wrenches`` what all of it does to a link; ``meetings`` are who may press a layer
that makes its own force. ``guard`` is the watchman. ``weigh`` lays a known weight on the skin, where ``level_place``
finds one.
"""
