"""Detection of contacts in taxel readings.

``regions``             a contact region, and the graph of neighbouring taxels
``detection``           finds regions in each frame
``close_contacts``      separates contacts whose touched taxels are connected
``tracking``            keeps their ids through motion, merging, splitting and short absence
``centre_of_pressure``  place on map and body, ellipse of the region, and uncertainty of both
``image_centre``        the centre computed from the pixels of a tactile image, as in the paper
``error_budget``        uncertainties of force and place, with their named parts
``taxel_noise``         noise and threshold of each taxel, estimated from readings without touch
``filled_readings``     readings of broken taxels, estimated from their neighbours
``unpressed_readings``  which readings next to a contact count as pressure
``contact_shear``       shear and slip of a contact; ``shear_estimation`` computes them from the tractions of taxels
``below_threshold``     notes on forces that no taxel reports
"""
