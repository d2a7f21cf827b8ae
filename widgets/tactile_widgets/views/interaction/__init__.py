"""Mouse gestures on the views, without Qt."""
