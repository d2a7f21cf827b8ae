"""Control of contacts by a task, shared by the six controllers that have one.

``tasks``              goals of each contact at each tick
``contact_selection``  contacts with a force goal, and those that the joints cannot relieve
``schemes``            six control schemes: joint velocities from errors of place and force
``monitors``           unsafe motion, contacts that do not follow, and energy given to contacts
"""
