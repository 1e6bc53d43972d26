"""Textures that follow a finger: motion in, blocks of samples out, within one block's time.

`engine` renders, `motion` says how the finger moves, `textures` (out of a `texture_table`) and `surface` are what it
moves over, `contact` what happens when it lands, `output` what a display gets (by its family's `drives`, through an
`equaliser`), `backends` where the blocks go, and `packets` and `osc` how a game engine talks to it.
"""
