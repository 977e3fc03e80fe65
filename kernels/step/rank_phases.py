"""Names of the phases of a static solve that several ranks share, and places of the numbers that control a phase."""

# phases, in the order of an iteration (rank_solve.py)
MEASURE, ASSEMBLE, JUDGE, LINEARISE, INVERT, BEGIN, EXTRAPOLATE, ADVANCE, END, LENGTH, MOVE, CONCLUDE = range(12)
# more phases, where every rank has all contact nodes (rank_copies.py)
SOLVE, RENEW = range(12, 14)
# numbers of `control`: the phase; its island; 1 at the first measure of a time step; first and end pack or node;
# relaxation, factor of the extrapolation or part of the move; 1 for a backward sweep; from RESULT on three results
PHASE, ISLAND_AT, FIRST, BEGIN_AT, END_AT, FACTOR, BACKWARD, RESULT = range(8)
CONTROL = RESULT + 3
MEASURED = 4  # numbers of a contact node: force of its contact cells (3) [N], and the sum of their magnitudes [N]
