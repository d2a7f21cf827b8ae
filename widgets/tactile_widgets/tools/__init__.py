"""The tools a person takes; ``registry`` lists them.

``map_editing`` has those that edit the map through the editor, ``control`` those that set path, target and force
through the settings editor.
"""
