"""How good a tactile map is, in numbers.

``distortion`` is what flattening does to each face, and patterns that show it; ``topography`` what it does to each
taxel's neighbourhood, against distances over the body; ``quality`` is all of it together. ``comparison`` sets two maps
of the same taxels side by side, also one drawn by hand.
"""
