"""Selection of the plots that are shown, and of their taxels."""
