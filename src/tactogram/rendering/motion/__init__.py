"""Motion of a finger: files and simulated hands, the state that follows from samples, and its path."""
