"""What is edited and selected, independent of any view.

``stage_settings`` brings the document to the stages that ``tactile_maps.studies`` measures, and their settings back.
``map_editor`` is the only caller that changes the map document; ``taxel_selection`` is which taxels and which contact
region are selected, and their colours; ``taxel_search`` finds taxels by id, number or module.
"""
