"""The plan of a run: what a scene needs, as host data; nothing is allocated and no kernel is compiled here.

How it works. `planning.plan` decides the terms of a scene and makes a `BodyPlan` of every body (`body_plan`):

    lumped_mass, removal, redistribution   masses of the nodes, which contact nodes lose theirs, which receive it
    rotation, locking                      bodies that spin, cells that lock
    contact_graph, sweep_order             the surface problem of the static solve, coloured and in lanes
    packing                                cells in packs of lanes, packs in chunks
    measured                               the columns of the rows of a history
    describe                               the plan in words, with bytes
"""
