"""Pictures: triangles to pixels."""
