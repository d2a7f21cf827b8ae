"""From what presses the skin to what its taxels report; no physics engine is asked but by the models that name one.

``loads`` are the bodies that press and one of them pressing a link at one instant, ``elastic_layer`` what the cover is
made of, ``poke`` what a finger does, as data. ``broadphase`` finds the points near a load, those of the skin and bare
ones of its link; ``models`` spread its force over them, one model a file, by the level and the tilt of a bed of springs
(``winkler``).
``receptive_field`` says what each taxel feels of that, ``half_space_stress`` what one feels that lies below the
surface. ``contact_notes`` are what a model did otherwise than asked.
``press`` is one touch of a skin that stands still. ``sensor_effects`` are what the electronics add (noise,
thresholds, delays), ``sensor_chain`` runs those that are on.
"""
