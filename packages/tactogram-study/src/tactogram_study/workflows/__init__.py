"""Studies with people: sessions, simulation, analysis, power."""
