"""Setups with known truth, on which methods are measured.

``reference_bodies``  meshes by formula at any resolution, and a flat skin whose map is the identity
``reference_touch``   a ball pressed into a densely sampled bed of springs, on flat and tubular skin
``contact_bench``     skins and bodies in static equilibrium
``bent_skin``         skin of given curvature at the same place and posture
``slit_map``          a skin with additional seams where it is touched
``covered_lattice``   taxels below a cover and their readings under a known force
``pressed_robot``     a robot at home, pressed by a probe
``fixed_ball``        a robot at home next to a fixed ball that presses its skin
``path_following``    that robot on a path, with its true errors
``force_loop``        force loop of a whole robot as a linear system
``decision_scenes``   scenes for the study of effects
``isomap``            a map by Isomap, as published for real skins
"""
