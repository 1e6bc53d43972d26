"""Sample streams: from bytes and packets to evenly spaced samples."""
