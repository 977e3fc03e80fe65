"""Static solve that places the massless contact nodes in every step.

Read control.py (when to solve), solve.py (one iteration), then the two linear solvers sweeps.py and mprgp.py, and
massless_contact.py (prediction before the solve, contact forces after it).
"""
