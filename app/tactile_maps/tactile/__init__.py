"""Tactile sensing: loads on the skin become readings of its taxels. Only models that name a physics engine use one.

``mechanics``  loads, the elastic cover, springs below a body, and what each taxel measures
``models``     contact models, which distribute a load over taxels
``sensors``    effects of the sensor: noise, thresholds, delays and others
``poke``       touch of a finger, as data
``press``      one touch of a skin at rest
``babbling``   random touches, for learned maps
"""
