"""From bytes and packets to evenly spaced samples."""
