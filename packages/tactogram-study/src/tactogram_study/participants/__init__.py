"""Participants' pages: everything that participants of a study can reach."""
