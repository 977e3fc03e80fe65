"""Contact terms: each owns its arrays and launches its kernels; what a scene does not need is never imported.

How it works, in the order of a step of the explicit scheme:

    term              gaps to the obstacles and the contact force of every kind of contact
    obstacles         records of the positions of the obstacles
    massless_contact  load and prediction of the massless nodes; static_solve then places them
    friction          Coulomb's law in the kicks and in the static solve; layered_friction limits it by a layer of metal

`contact_terms.make_contact` chooses the term of a scene. A term lists its arrays (`owned`) for `Result.memory`.
"""
