"""Place given taxels on a robot's links."""
