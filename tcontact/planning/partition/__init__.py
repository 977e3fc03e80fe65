"""The partition of a mesh over processes: which cells each one takes, and what it shares with the others.

How it works. `cut.cut_cells` gives every cell a rank, contact cells first; `parts.parts_of` lists for every rank its
nodes and the copies of them that others have; `contact_parts` lists, for the static solve, the contact nodes that a
rank solves and those whose increments it receives. These are plain index arrays of the whole mesh. `body_part` makes
the plan of a part of a body, `domain_part` that of a domain, which `message` takes to its rank with an `outline` of the
whole plan; `cell_graph` is what METIS cuts; `shared_contact` and `graph_part` say what ranks that
share a contact have of it and exchange.
"""
