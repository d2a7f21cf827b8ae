"""Reading contacts: what is touched, how hard, where on the map and on the body, and what that means.

``region`` is the value. ``reader`` finds regions in taxel pressures frame by frame: ``graph`` gathers touched taxels,
``follow`` keeps their names (``lost`` those of contacts that are gone for a moment), ``place`` finds the centre of
pressure on map and body (``walk`` from triangle to triangle), ``shape`` and ``accuracy`` say how they lie and how well
they are known. ``self_touch`` links the two regions where the robot touches itself; ``event`` and ``events`` put into
words what contacts do. ``estimators`` are other ways to a force than the sum of pressure times area, and
``force_reader`` gives regions what the chosen one finds. ``sense`` is all of that together, as ``reading_settings``
say.
"""
