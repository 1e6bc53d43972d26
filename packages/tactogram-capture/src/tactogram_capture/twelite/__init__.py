"""TWE-Lite receivers: parser, messages, simulator."""
