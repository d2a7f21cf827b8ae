"""Panels of what the skin reads: contacts, events, and the live input of a real skin."""
