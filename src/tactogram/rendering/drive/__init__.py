"""From a signal to the drive of a display."""
