"""Robots: from any file to one self-contained value, and the kinematics of a posture.

Reading order: ``robot`` (the value), ``load`` (which reader for which file) and ``library`` (robots by name); then the
readers ``mjcf``, ``urdf``, ``bare_mesh`` and ``icub``, which lean on ``safe_files`` (nothing climbs out of its folder),
``mjcf_cut``, ``packages`` (package:// addresses), ``mesh_file`` and ``asset_store`` (only checked triangles reach
MuJoCo). All of them end in ``build``: ``strip`` the scene, make do with ``thin_meshes``, exclude touching neighbours
(``exclusions``), draw the links (``tessellate``), ``prove`` that it runs. ``compile`` turns a Robot back into a MuJoCo
spec; ``configuration`` answers where its links are.
"""
