"""The page Edit: haptic effects on a timeline, their files, and their audition."""
