"""Files of frames: VTKHDF, written and read, and .vtu and .xdmf for other programs."""
