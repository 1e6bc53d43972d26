"""Textures that follow a finger: motion in, blocks of samples out, within one block's time.

`engine` renders `textures` (from a `texture_table` or a `noise_texture`) under the finger of
`tactogram.rendering.motion`, `contact` adds the transients of landings, `output` drives a display, `backends` play or
send the blocks, and `network` connects a game engine.
"""
