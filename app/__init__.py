"""Everything that is true without a screen.

The folders follow the chain from body to motion; read them in this order:

``geometry``    meshes, poses, points on a surface
``robots``      a robot from any file, and the kinematics of a posture
``skin``        patches of taxels worn by links: placed by themselves, or imported
``maps``        the skin cut, flattened and laid out: the tactile map, with its inverse and its quality
``editing``     a map as a person edits it: immutable documents, edits from one to the next, history, files
``simulation``  physics of the arm and of fingers that press it; pressure on the taxels
``contacts``    contact regions read from the map and back-projected to the body
``control``     what the joints do about a contact
``session``     one run of all of it, tick by tick, as frozen frames
``recording``   sessions in files that survive a crash and can be replayed and verified
``experiments`` what accuracy costs in time, as tables and plots, and on a person's own skin
``cli``         the command line

A folder may import only those above it (and ``control`` and ``simulation`` do not know each other). Nothing here
imports Qt or VTK; that is the ``widgets`` package. ``__main__`` joins the two.
"""
