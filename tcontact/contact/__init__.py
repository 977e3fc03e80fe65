"""Contact: each term owns its arrays and launches its kernels; what a scene does not need is never imported.

How it works, in the order of a step of the explicit scheme:

    term              gaps to the obstacles and the contact force of every kind of contact
    obstacles         the obstacles of a scene as the kernels see them: records of where they are
    massless_contact  load of the massless nodes and their prediction; static_solve then places them
    friction          Coulomb's law on the kicks and in the static solve; layered_friction limits it by a layer of metal

`contact_terms.make_contact` chooses the term of a scene. The terms of the cells (`cells.internal_force`) and of the
nodes (`nodes.boundary_nodes`) stand below, the steps that call them above (`schemes.explicit`). A term names its arrays
(`owned`), so that `Result.memory` can count them.
"""
