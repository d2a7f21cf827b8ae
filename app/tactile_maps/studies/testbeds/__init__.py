"""Setups whose truth is known, on which methods are measured.

``reference_bodies``  meshes by formula at any fineness, and a flat skin whose map is the identity
``reference_touch``   a ball pressed into a densely sampled bed of springs, on a flat and on a tubular skin: what taxels
                      should read
``pressed_robot``     a robot held at home and pressed by a probe, run at one time step
``beside_ball``       a robot at home beside a fixed ball that presses its skin, and somebody's finger elsewhere
``path_following``    that robot led along a path, with its true errors
``covered_lattice``   taxels below a cover and what they read under a contact of known force
``isomap``            a map as published ones were made, to compare with
``force_loop``        the force loop of a whole robot as a linear system: from which gain on it is unstable
"""
