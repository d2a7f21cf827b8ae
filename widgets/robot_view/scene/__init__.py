"""What the robot view draws, on any PyVista plotter: no Qt here.

``robot_scene`` draws it all, from where ``opening_view`` has it first seen: ``skin_actors``, ``link_actors``,
``object_actors``, ``contact_marks`` and ``tool_and_task_marks``, each by the meshes of ``surface_marks``; over them the
``body_layers`` of View > Overlay.
"""
