"""Tools of the user; ``registry`` lists them.

``map_editing`` contains the tools that edit the map through the map editor, ``control`` those that set path, target and
force through the settings editor.
"""
