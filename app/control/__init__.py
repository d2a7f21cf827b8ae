"""What the joints do about a contact. Knows no simulation: the same controller could drive hardware.

``command`` holds the values; each law has its file (``impedance``, ``hold_force``) and answers the same question
(``law``); ``contact_motion`` is the controller that a session asks, whichever law is on.
"""
