"""From a scene to what exists in its run. Host data only: nothing is allocated and no kernel is compiled here.

How it works. `planning.plan` decides the terms of a scene and makes a `BodyPlan` of every body (`body_plan`):

    lumped_mass, removal, redistribution   masses of the nodes, which contact nodes lose theirs, and who takes it
    rotation, locking                      what speaks against a choice: bodies that spin, cells that lock
    contact_graph, sweep_order             the surface problem of the static solve, coloured and in lanes
    packing                                cells in packs of lanes, packs in chunks
    measured                               what the rows of a history hold
    describe                               all of it in words, with bytes
"""
