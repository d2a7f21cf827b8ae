"""The skin: patches of taxels on links, and the four ways to get one.

Read in this order:

``skin``               taxels, their identity and quadrature, patches, and all of them as one skin: the values
``skin_file``          a skin as npz, checked on reading
``open``               whatever a user has (robot, mesh, taxels, skin, map) becomes a skin
``cover``              a skin that places itself on a robot: links chosen, wrapped, kept clear of joints
``mesh_skin``          a skin right on a bare mesh
``fit``                measured taxel positions fitted to a robot's link
``touchable_surface``  the surface of rigidly joined links that can be touched
``taxel_placement``    the taxels a person asks for: number or pitch, keep-out zones, even or in a pattern of lattice or
                       modules; where on a wrapped link skin can lie
``reconstruction``     a surface laid through taxels that come without one, its boundary extended
``bare_surface``       points on the parts of skinned links that bear load without skin
``link_hulls``         convex hulls of links with their skin; pairs of links whose hulls overlap
``link_pieces``        convex pieces with which a link collides where its hull would span hollows of its skin
``calibration_error``  the skin as a calibration with errors would have it
``formats``            taxels in the files of other programs
"""
