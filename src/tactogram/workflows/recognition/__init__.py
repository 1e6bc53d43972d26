"""Recognition: classification, retrieval and word scores of recordings."""
