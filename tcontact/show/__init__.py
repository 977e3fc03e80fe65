"""Pictures, curves and notebooks, which are drawn from results alone."""
