"""Physics terms: each owns its arrays and launches its kernels; what a scene does not need is never imported."""
