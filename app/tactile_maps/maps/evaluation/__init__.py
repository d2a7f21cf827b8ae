"""Measures of a map's quality.

``distortion``  change of each face by flattening, and patterns that show it
``topography``  neighbourhoods and distances of taxels, compared with distances over the body
``quality``     summary of both
``comparison``  two maps of the same taxels, for example an automatic and a drawn one
"""
