"""Pictures, curves and notebooks, drawn from results alone."""
