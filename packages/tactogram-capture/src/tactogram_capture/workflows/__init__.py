"""Recording sessions, logs and live recognition."""
