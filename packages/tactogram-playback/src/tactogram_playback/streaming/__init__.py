"""Textures that follow a finger: motion in, blocks of samples out, within one block's time.

`engine` renders, `motion` describes the finger, `textures` (from a `texture_table`) and `surface` are what it moves
over, `contact` adds the transients of landings, `output` drives a display, `backends` play or send the blocks, and
`network` connects a game engine.
"""
