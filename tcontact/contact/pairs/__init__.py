"""Contact between deformable bodies: surfaces, search, coupling rows (METHOD 7)."""
