"""Contact between deformable bodies: surfaces, search, coupling rows (METHOD, pairs of bodies)."""
