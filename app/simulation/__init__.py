"""Physics of the robot, of the things around it and of the fingers that press it, and what its skin reads of that.

A ``scene`` says what for (``scene_file`` finds it, ``scene_text`` and ``scene_reader`` read it, with ``line_numbers``
and ``units`` for mistakes). From its ``needs``, ``rules`` ``decide`` each effect of ``effect_table``; ``lacks`` warns
of what is off and needed, ``stability`` of what was measured to be unsteady. ``objects`` become ``bodies``, and
``motion`` is the robot's own way.

``assemble`` compiles a model of exactly the ``effects`` that are on: ``object_geoms`` adds things, ``contact_pairs``
says who may touch whom, ``real_stiffness`` how hard. ``physics`` steps it, ``simulation`` adds fingers (``poke``,
``fingers``) and the sensor, and ``carry_state`` takes the state along when effects change. ``contact_loads`` are what
presses the skin at one instant, by ``geom_shapes``; ``meetings`` are who may press a layer that makes its own force.
``guard`` is the watchman. ``stimuli`` is a scripted hand, ``babbling`` one that touches at random for maps to be
learned from. ``weigh`` lays a known weight on the skin, where ``level_place`` finds one.
"""
