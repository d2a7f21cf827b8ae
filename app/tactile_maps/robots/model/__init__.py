"""A robot as links and joints, built from a MuJoCo model."""
