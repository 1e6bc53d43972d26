"""Training: planning, running, resuming and packing runs."""
