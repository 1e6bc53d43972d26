"""Recording sessions: plan, takes, checks, console."""
