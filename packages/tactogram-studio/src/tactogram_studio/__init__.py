"""Browser pages: the studio for designers, and studies for participants and experimenters.

They call public functions only, so everything they do is also a command. Pages load nothing from other machines.
"""
