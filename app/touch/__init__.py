"""From what presses the skin to what its taxels report; no physics engine is asked but by the models that name one.

``shapes`` and ``mesh_shape`` are the bodies that press, ``load`` is one of them pressing a link's skin at one instant,
``layer`` what the cover is made of. ``bed`` finds the skin's quadrature points (``points``) under a load, with
``cells`` to search by and a ``neighbourhood`` to remember. ``models`` spread its force over them, one model a file;
``fill`` is the level of a bed of springs, ``balance`` its tilt, ``love`` and ``fft_blur`` what lies below the surface.
``receptive_field`` says what each taxel feels of that, ``sensor`` what the electronics add: noise, thresholds, delays,
one stage a file. ``poke`` is what a finger does, as data; ``push`` what a model did by itself; ``babbling`` touches a
skin at random for maps to be learned from.
"""
