"""airside fleet: weights for many boxes, in waves."""
