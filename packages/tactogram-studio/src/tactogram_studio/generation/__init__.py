"""Generation for the page Make: the form of a run, what it generates, and what one browser sees."""
