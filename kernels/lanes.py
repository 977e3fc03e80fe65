"""Sizes that the packed cells (tcontact/packing.py) and the kernels that walk them agree on."""

CHUNKS = 8  # fixed number of force rows: the same bits at any thread count
WIDTHS = {"hex8": 8, "hex8-affine": 8, "hex8-reduced": 8, "tet4": 8}  # lanes of a pack
TABLE = 5  # numbers per chunk in chunk_table: first pack, end pack, row base, end of its cells, 1 if they own rows
SWEEP_LANES = 4  # contact nodes of one colour that a sweep takes at once
