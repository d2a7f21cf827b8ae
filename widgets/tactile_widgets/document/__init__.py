"""Documents that the user edits, and the selection; independent of any view.

``map_editor``       the only code that changes the map document
``posture_editor``   the target posture of the robot
``recording_notes``  annotations of the replayed recording
``taxel_selection``  selected taxels and contact region, and their colours
``taxel_search``     search for taxels by id, number or module
``stage_settings``   settings of the stages that ``tactile_maps.studies`` measures, read from and applied to a map
"""
