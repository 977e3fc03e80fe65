"""The static solve of the massless contact nodes: measure, tangent, sweeps."""
