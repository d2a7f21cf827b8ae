"""What lies over the map's scene, drawn in pixels: it keeps its size when the map is enlarged.

``map_painter`` draws all of it, and asks ``legend_place`` where the legends hide least. ``map_layers`` are what
View > Overlay shows or hides, a class each; ``task_layer`` is the largest of them, the controller's task.
"""
