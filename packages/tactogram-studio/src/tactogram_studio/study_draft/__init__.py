"""Draft of a study that is being edited: its tables, fields and stimuli."""
