"""The page Materials: data sets, recordings, what is like a new one."""
