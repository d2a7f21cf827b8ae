"""Placement of a skin on links of a robot.

``cover``            selects links, wraps them, keeps joints clear and places taxels
``measured_taxels``  fits measured positions to a link and the links fixed to it
``grid``             makes taxel grids between two corners
``rigid_body``       links without a joint between them, and their surface that can be touched
``frame_match``      finds the frame for which positions are stated
``cover_patches``    makes patches on a cover around places
``alignment``        moves groups of taxels onto their mesh, or onto touches at known places
"""
