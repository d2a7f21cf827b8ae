"""What is edited and selected, independent of any view.

``map_editor`` is the only caller that changes the map document; ``taxel_selection`` is which taxels and which contact
region are selected, and their colours.
"""
