"""Skins: patches of taxels on links, and the ways to make them.

``model``              taxels, patches and the skin; its file; surfaces that can be touched or that stay bare
``open``               makes a skin of any input: robot, mesh, taxels, skin or map
``fitting``            ``cover`` places a skin on a robot, ``fit`` fits measured positions to a link
``mesh_skin``          a skin on a bare mesh
``taxel_placement``    positions of taxels: number or pitch, zones to keep out of, patterns, cells
``reconstruction``     a surface for taxels without one
``formats``            taxels in files of other programs
``link_hulls``         convex hulls of links with their skin, and pairs that overlap
``link_pieces``        convex pieces for links whose hull would cover hollows of their skin
``collision_shapes``   shapes with which links collide, hull or pieces, and pairs of links that never collide
``controllable``       share of a skin on which contact forces can be controlled
``calibration_error``  a skin with errors of calibration
"""
