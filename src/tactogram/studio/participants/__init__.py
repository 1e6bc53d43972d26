"""Participants' pages: all that participants of a study can reach."""
