"""Ultrasonic transducers: circuit, simulation, resonance tracking, generators."""
