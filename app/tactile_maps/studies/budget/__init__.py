"""The best settings of several stages within a limit of time or error: ``measurement`` is what there is to choose from,
``proposal`` the choice, ``wording`` what is said of it.
"""
