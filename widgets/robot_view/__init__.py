"""The body: the robot in three dimensions, its skin coloured by what it feels.

``robot_scene`` draws on any PyVista plotter and knows no Qt; ``pick`` finds the skin under a pixel and knows neither.
``canvas`` is a widget that shows a plotter, in two kinds; ``robot_view`` wires them and emits what the hand did.
"""
