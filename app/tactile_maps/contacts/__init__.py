"""Reading contacts: what is touched, how hard, where on the map and on the body, and what that means.

``regions`` holds the value, and the graph of taxels. ``detection`` finds regions in taxel pressures frame by frame,
``tracking`` keeps their ids, ``centre_of_pressure`` places them on map and body, with their ellipse and error bars,
``image_centre`` takes the centre from an image's pixels where that is asked for.
``force_estimation`` holds other ways to a force than the sum of pressure times area. ``self_touch`` links the two
regions where the robot touches itself; ``events`` put into words what contacts do. ``pipeline`` is all of that
together, as its settings say. ``below_threshold`` notes forces that no taxel reports.
"""
