"""Setups whose truth is known, on which methods are measured.

``reference_bodies``  meshes by formula at any fineness, and a flat skin whose map is the identity
``reference_touch``   a ball pressed into a densely sampled bed of springs, on a flat and on a tubular skin: what taxels
                      should read
``pressed_robot``     a robot held at home and pressed by a probe, run at one time step
``path_following``    a robot beside a fixed ball, led along a path, with its true errors
``force_loop``        the force loop of a whole robot as a linear system: from which gain on it is unstable
"""
