"""Planning: from a scene to what exists in its run. Nothing is allocated and no kernel is compiled here.

How it works. `planning.plan` decides the terms of a scene and makes a `BodyPlan` of every body (`body_plan`); a
`Domain` (`domain`) joins the bodies that take their steps together:

    lumped_mass, removal, redistribution   masses of the nodes, which contact nodes lose theirs, and who takes it
    rotation, locking                      what speaks against a choice: bodies that spin, cells that lock
    node_volumes                           volume changes averaged at nodes, as lists
    contact_graph, sweep_order             the surface problem of the static solve, coloured and in lanes
    static_solver                          whether sweeps or MPRGP solve it, and why
    domain, islands                        one numbering of nodes, blocks of cells; the contact nodes of each body
    node_order                             numbering of nodes and cells that keeps neighbours together in memory
    packing, chunk_rows, domain_packs      cells in packs of lanes, packs in chunks with force rows of their own
    partition                              a mesh cut over processes: parts, their copies of nodes, contact nodes
    device_path                            what threads of a GPU step, and what keeps a domain off that path
    measured                               which numbers the rows of a history hold
    describe                               the plan in words, with bytes
"""
