"""The page Live: a sensor, what it is taken for, sessions by a plan."""
