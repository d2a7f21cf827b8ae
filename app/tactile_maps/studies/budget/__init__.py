"""Best settings of several stages within a limit of time or error.

``measurement``  settings to choose from, with error and time
``proposal``     the choice
``wording``      its text
"""
