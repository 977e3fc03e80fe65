"""A second, independent implementation of the method in plain numpy, for the tests to compare with.

It shares no code with the package and solves the contact problem by another algorithm (a dense active set instead of
projected Gauss-Seidel). Clarity before speed: small meshes only. Signs: gap >= 0 is open,
the normal points from the wall into the body, contact forces push.
"""

from oracle import meshes
from oracle.cells import Quadrature, assemble, energy, internal_force, quadrature, tangent, von_mises
from oracle.central_difference import Body, History, Impulse, Massless, Penalty, Plane, run, stable_step
from oracle.exact import BarImpact, bar_metrics, characteristic_bar
from oracle.laws import LinearElastic, MooneyRivlin, NeoHookean, StVenantKirchhoff
from oracle.mass import Redistribution, choose_removal, face_area_weights, lumped_cell_mass, redistribute
from oracle.mean_dilatation import MeanDilatation
from oracle.node_averaged import NodeAveraged
from oracle.reduced import ReducedHex
from oracle.static_contact import StaticContact, solve_lcp

__all__ = [
    "BarImpact",
    "Body",
    "History",
    "Impulse",
    "LinearElastic",
    "Massless",
    "MeanDilatation",
    "MooneyRivlin",
    "NeoHookean",
    "NodeAveraged",
    "Penalty",
    "Plane",
    "Quadrature",
    "Redistribution",
    "ReducedHex",
    "StVenantKirchhoff",
    "StaticContact",
    "assemble",
    "bar_metrics",
    "characteristic_bar",
    "choose_removal",
    "energy",
    "face_area_weights",
    "internal_force",
    "lumped_cell_mass",
    "meshes",
    "quadrature",
    "redistribute",
    "run",
    "solve_lcp",
    "stable_step",
    "tangent",
    "von_mises",
]
