"""Contact of nodes: constraint rows, the obstacles that fill them, loads, friction, the viscosity of contact cells.

`obstacle_rows` fills the rows from `obstacles` and `obstacle_shapes`; `contact_load` and `friction` read rows alone;
`friction_laws` sets their coefficients where these vary.
`islands` tells where the contact nodes of every body stand.
"""
