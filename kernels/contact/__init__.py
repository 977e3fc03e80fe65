"""Contact of nodes: gaps to obstacles, loads, friction, viscosity of contact cells."""
