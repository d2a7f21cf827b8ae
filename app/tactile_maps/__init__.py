"""Tactile maps of robot skin: everything that needs no display.

The names below are the public library; each is imported when it is first used. Units are SI. Names of positions and
normals state their frame (``link_position``, ``map_point``, ``world_normal``); those of a ``Skin`` are in the frame of
the link that carries them. Examples in the docstrings continue this one:

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

The packages follow the path from the body to its motion; read them in this order:

``core``        array types, errors, files
``geometry``    meshes, poses, points on a surface
``robots``      robots from any file, and their kinematics
``skin``        patches of taxels on links: generated or imported
``flattening``  flattening of one patch, one-to-one
``maps``        all patches on one plane: the tactile map with its inverse, image and quality
``editing``     editing of a map: immutable documents, history, files
``tactile``     from loads on the skin to readings of its taxels: contact models and sensor effects
``contacts``    contact regions on the map, and their places on the body
``stimuli``     scripted fingers: pokes, strokes, grasps
``scene``       what is simulated and for which task; effects follow from this
``simulation``  physics with only what the scene needs
``control``     motion of the joints in response to contacts
``session``     runs of a scene, tick by tick, as frozen frames
``recording``   sessions in files that survive a crash and can be replayed and verified
``live``        readings of real skins as frames of a session
``export``      recordings for other programs, sessions in their viewers
``learning``    Gymnasium environments in which a policy learns from touch
``studies``     accuracy and its cost in time, as tables and plots
``cli``         command line; ``plot`` draws with matplotlib

A package may import only those above it; ``control`` and ``simulation`` do not import each other. Nothing here imports
Qt or VTK. The window is the package ``tactile_widgets``, whose ``__main__`` is the program.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
