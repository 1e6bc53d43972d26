"""The page Train: trainings as processes of their own, watched and compared."""
