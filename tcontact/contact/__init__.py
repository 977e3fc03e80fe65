"""Contact terms: each owns its arrays and launches its kernels; what a scene does not need is never imported.

How it works, in the order of a step of the explicit scheme:

    obstacles         records of the obstacles as the kernels see them, with their poses while they move
    constraint_rows   gap, normal and velocity of the partner, and the force, for every constraint of a contact node
    term              the contact set, its islands and the contact force, which every kind of contact has
    massless_contact  load of the massless nodes and their prediction; static_solve then places them
    shared_solve      the same solve where several ranks have contact nodes (shared_islands: what they exchange)
    copied_solve      the same by projections, as of pairs of bodies, which every rank does as a whole
    bundles           the arrays of all these as the kernels take them
    friction          Coulomb's law on the kicks and in the static solve; layered_friction limits it by a layer of metal
    device_layers     what layered_friction keeps, on a GPU, which steps the layers

Obstacles fill the rows; all other parts read rows and know no obstacles. `contact_terms.make_contact` chooses the term
of a scene. The internal force (`cells.internal_force`) and the boundary nodes (`nodes.boundary_nodes`) stand below, the
steps that call them above (`schemes.explicit`). A term lists its arrays (`owned`), so that `Result.memory` can count
them.
"""
