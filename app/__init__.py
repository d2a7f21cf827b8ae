"""Everything that is true without a screen.

The folders follow the chain from body to motion; read them in this order:

``geometry``    meshes, poses, points on a surface
``robots``      a robot from any file, and the kinematics of a posture
``skin``        patches of taxels worn by links: placed by themselves, or imported
``maps``        the skin cut, flattened and laid out: the tactile map, with its inverse and its quality
``editing``     a map as a person edits it: immutable documents, edits from one to the next, history, files
``touch``       from what presses the skin to what its taxels report: contact models and sensor effects
``stimuli``     scripted hands: pokes, strokes, grasps, from a file or recorded from a person
``scene``       what is simulated and what for; each effect follows from the needs or from a wish
``simulation``  physics that holds only what the scene calls for, stepped; fingers on the skin
``contacts``    contact regions read from the map and back-projected to the body
``control``     what the joints do about a contact
``session``     one run of all of it, tick by tick, as frozen frames
``recording``   sessions in files that survive a crash and can be replayed and verified
``experiments`` what accuracy costs in time, as tables and plots, and on a person's own skin
``cli``         the command line; ``toml`` reads what people write for it

A folder may import only those above it (and ``control`` and ``simulation`` do not know each other). Nothing here
imports Qt or VTK; that is the ``widgets`` package. ``__main__`` joins the two.
"""
