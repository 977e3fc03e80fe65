"""The static solve, which places the massless contact nodes (METHOD 2). It reads constraint rows, not obstacles.

`massless_contact` predicts the nodes and takes their contact force from the force pass; `solve` measures the contact
cells and linearises (`surface_tangent`, `reduced_tangent`); `control` decides what follows; `sweeps` (projected
Gauss-Seidel, with `massless_node`, `sliding` and `friction_lanes`) or `mprgp` (conjugate gradients with bounds, in a
`node_basis`) solve the linear problem. Bodies in contact with each other couple their nodes (`pair_step`), and where
they have obstacles beside them a node has several bounds (`chosen_rows`, `several_bounds`).
"""
