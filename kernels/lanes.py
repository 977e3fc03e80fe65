"""Sizes that the packed cells (tcontact/packing.py) and the kernels that walk them agree on."""

CHUNKS = 8  # fixed number of force rows: the same bits at any thread count
WIDTHS = {"hex8": 8, "hex8-reduced": 8, "tet4": 8}  # lanes of a pack
TABLE = 4  # numbers per chunk in chunk_table: first pack, end pack, row base, unused
