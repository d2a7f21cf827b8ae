"""Control: laws, tasks and settings from the menu and the panel; laws compared side by side."""
