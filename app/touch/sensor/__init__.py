"""What a sensor makes of the pressure on its taxels, one effect a file, each switched on by itself.

``effects`` holds the choice, ``stage`` is what every effect answers, ``chain`` runs those that are on, in the order of
the signal: cover, capacitor, amplifier, converter, bus.
"""
