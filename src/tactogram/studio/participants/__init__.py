"""What participants of a study reach: a page of their own, and nothing else."""
