"""Files of frames: VTKHDF written and read, .vtu and .xdmf for other programs."""
