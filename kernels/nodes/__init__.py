"""The phases of nodes: sum of the forces, kick and drift, supports, damping, periodic images."""
