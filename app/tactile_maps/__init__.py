"""Tactile Maps as a library: everything that is true without a screen.

The names below are what a program needs; each is imported when it is asked for. Units are SI. Positions and normals are
in the frame that their name says (``link_position``, ``map_point``, ``world_normal``); those of a ``Skin``, in the
frame of the link that carries them. Examples in the docstrings go on from this one:

    >>> import tactile_maps as tm
    >>> robot = tm.load_robot("arm")
    >>> skin = tm.cover_robot(robot, tm.CoverSpec(links=("hand",), taxels=60))
    >>> tactile_map = tm.build_map(skin)
    >>> session = tm.Session.of(robot, tactile_map)

Robots      ``load_robot``, ``list_robots``, ``Robot``, ``Configuration`` (where links are at a posture)
Skin        ``cover_robot`` with a ``CoverSpec``, ``open_skin`` with ``SkinOptions``, ``Skin``
Maps        ``build_map``, ``TactileMap``, ``TactileImage``, ``back_project``, ``measure``, ``compare_maps``,
            ``save_map``, ``load_map``
Touch       ``press_skin``, ``read_contacts``, ``ContactRegion``
Sessions    ``Scene``, ``load_scene``, ``prepare``, ``Session``, ``ControlSettings``, ``Frame``, ``record``,
            ``open_recording``
Pictures    ``draw_map``, ``draw_contacts``, ``draw_forces``
Errors      all are ``TactileMapsError``

The folders follow the chain from body to motion; read them in this order:

``core``        named array types, errors, files: what all others stand on
``geometry``    meshes, poses, points on a surface
``robots``      a robot from any file, and the kinematics of a posture
``skin``        patches of taxels that cover links: placed by themselves, or imported
``flattening``  one patch cut and flattened, one-to-one
``maps``        all patches on one plane: the tactile map, with its inverse, its image and its quality
``editing``     a map as a person edits it: immutable documents, edits from one to the next, history, files
``tactile``     from what presses the skin to what its taxels report: contact models and sensor effects
``contacts``    contact regions read from the map and back-projected to the body
``stimuli``     scripted fingers: pokes, strokes, grasps, from a file or recorded from a person
``scene``       what is simulated and what for; each effect follows from the needs or from a choice
``simulation``  physics that holds only what the scene calls for, stepped; fingers on the skin
``control``     what the joints do about a contact
``session``     one run of all of it, tick by tick, as frozen frames
``recording``   sessions in files that survive a crash and can be replayed and verified
``live``        readings of real skins as frames of a session
``export``      recordings for other programs, sessions live in their viewers
``learning``    Gymnasium environments in which a policy learns from touch
``studies``     what accuracy costs in time, as tables and plots
``cli``         the command line; ``plot`` draws with matplotlib

A folder may import only those above it (and ``control`` and ``simulation`` do not know each other). Nothing here
imports Qt or VTK; that is the package ``tactile_widgets``, whose ``__main__`` is the program.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
