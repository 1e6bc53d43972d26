"""The pages in the browser: the studio of designers and the experiments of researchers.

It calls the public functions only; whatever it can do, a verb can. Everything is served from this machine, and nothing
is asked of another.
"""
