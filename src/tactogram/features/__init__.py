"""Between a signal and a network: torch, differentiable, invertible."""
