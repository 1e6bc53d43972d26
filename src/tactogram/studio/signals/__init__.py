"""How a signal is shown and heard on any page."""
