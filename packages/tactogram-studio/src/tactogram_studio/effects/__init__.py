"""Drawn haptic effects: tracks of an amplitude, a frequency and transients, their editing, their mix and files."""
