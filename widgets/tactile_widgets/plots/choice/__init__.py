"""Which plots show, and of which taxels."""
