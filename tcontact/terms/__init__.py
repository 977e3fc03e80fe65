"""Physics terms: each owns its arrays and launches its kernels; what a scene does not need is never imported.

How it works, in the order of a step of the explicit scheme:

    internal_force    one pass over the packed cells; ordinary nodes are kicked and drift in the same launch
    contact           gaps to the obstacles and the contact force of every kind of contact
    massless_contact  load of the massless nodes and their prediction; static_solve then places them (projected sweeps)
    friction          Coulomb's law on the kicks and in the static solve; friction_layer limits it by a layer of metal
    boundary_nodes    nodes with tensor mass, supports or contact: they move by matrices, not by a number
    images            periodic nodes follow their masters
    serial_step       all of the above beside the force pass in one launch; for small bodies whole steps, many a launch

`plan.py` decides which of them exist, `state.py` builds them for a body. A term names its arrays (`owned`), so that
`Result.memory` can count them.
"""
