"""Workflows: what each verb of the command line does, one function each."""
