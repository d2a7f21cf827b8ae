"""Placement of a skin on links of a robot.

``cover``  selects links, wraps them, keeps joints clear and places taxels
``fit``    fits measured positions to a link, and makes taxel grids between two corners
"""
