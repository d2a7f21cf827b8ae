"""The MCAP file of a recording: its messages, and what is done about damage."""
