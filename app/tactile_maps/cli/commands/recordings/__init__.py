"""Commands on a recording that is there: look at it again, cut, repair and write it for other programs."""
