"""Power of a study before it is run, by simulated participants."""
