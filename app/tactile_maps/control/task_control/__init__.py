"""Control of contacts by a task, as the six controllers with a task share it.

``tasks`` says what is wanted of each contact, tick by tick; the six ``schemes`` make joint velocities of the errors of
place and force; ``monitors`` stop what is unsafe.
"""
