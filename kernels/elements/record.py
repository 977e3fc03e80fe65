"""Record of a kind of cell: the functions that kernels call, each for the corners of one cell."""

from typing import Any, NamedTuple


class CellFunctions(NamedTuple):
    """Functions of the reference positions x[c][k] and displacements u[c][k] of the corners of a cell.

    force(x, u, weight, parameters, law, memory) returns [corner forces dW/du as [component][corner], energy, smallest
    det F - 1] and, in an element with hourglass modes, their energy; forces and energies are multiplied by the weight.
    law: a law, parameters: its parameters (materials/law.py); memory: state of its points (point_memory.py) or None;
    share: times the energies of the points, the energy of the cell without its weight. linear_force replaces `force`
    for the linear law, if it is not None. step_force(x, d, ..) takes the displacement d of a step that ends at the
    present positions x (cell_viscosity.py). viscosity(x, u, v, half, speed, square) returns the forces of the bulk
    viscosity (bulk_viscosity.py). gradient(x, u) returns H = du/dX at the centre. tangent: integration of the stiffness
    between contact nodes, "points", "mean-dilatation" or "node-averaged" (surface_tangent.py) or "reduced"
    (reduced_tangent.py). points: number of points that call the law, in the order of
    tcontact/planning/lumped_mass.py. averaged: the volume change V (J - 1), which volume(x, u) returns (for the linear
    law linear_volume), is averaged at nodes, and force has `averages_of` (cells/node_averages.py) as its last argument.
    stored: count of numbers that describe the cell at rest (tcontact/planning/cell_shapes.py), which force takes in
    place of x, as a list; 0 if it takes x. thread_force, linear_thread_force: the same forces for a thread of a GPU,
    which has few registers, thread_step_force: `step_force` for it; None: those above. point_gradient(x, u, point)
    returns [H, D times the weight] of one of several points.
    """

    corners: int
    force: Any
    step_force: Any
    viscosity: Any
    gradient: Any
    linear_force: Any = None
    tangent: str = "points"
    points: int = 8
    share: float = 1.0 / 512.0
    averaged: bool = False
    stored: int = 0
    volume: Any = None
    linear_volume: Any = None
    thread_force: Any = None
    linear_thread_force: Any = None
    thread_step_force: Any = None
    point_gradient: Any = None
