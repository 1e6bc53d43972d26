"""Signal display: pictures and sound of a signal on any page."""
