"""What the kernels know of a kind of cell: its functions, each of the corners of ONE cell."""

from typing import Any, NamedTuple


class CellFunctions(NamedTuple):
    """Functions of the reference positions x[c][k] and displacements u[c][k] of the corners of a cell.

    force(x, u, weight, parameters, law, memory) returns [corner forces dW/du as [component][corner], energy, smallest
    det F - 1] and, in an element that has hourglass modes, their energy; forces and energies times the weight. law: the
    update of a law and its parameters (materials/law.py); memory: what its points keep (point_memory.py), None =
    nothing. linear_force replaces it for the linear law, if it is there. step_force(x, d, ..) takes the displacement d
    of a step that ends at the present positions x (cell_viscosity.py).
    viscosity(x, u, v, speed, square) returns the forces of the bulk viscosity (bulk_viscosity.py).
    gradient(x, u) returns H = du/dX at the centre. tangent: how the stiffness between contact nodes is integrated:
    "points", "mean-dilatation" (surface_tangent.py) or "reduced" (reduced_tangent.py). points: how many points call the
    law, numbered as in tcontact/planning/lumped_mass.py.
    """

    corners: int
    force: Any
    step_force: Any
    viscosity: Any
    gradient: Any
    linear_force: Any = None
    tangent: str = "points"
    points: int = 8
