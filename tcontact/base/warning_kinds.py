"""Classes of warnings, so that a script can select, silence or raise each."""

from __future__ import annotations

import sys
import warnings

PACKAGE = __name__.partition(".")[0]


def warn(text: str, kind: type[Warning]) -> None:
    """Warn, naming the line outside the package that led here."""
    level, frame = 2, sys._getframe(1)
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] == PACKAGE:
        level, frame = level + 1, frame.f_back
    warnings.warn(text, kind, stacklevel=level)


class MeshWarning(UserWarning):
    """Cells of a mesh were turned, a part of a mesh file was changed or left out, or nodes lie in one place without
    joining their cells."""


class RotationWarning(RuntimeWarning):
    """A body or a wall turns too far: for removal="normal", whose directions are those of the start, or for a body of
    `LinearElastic`, which holds for small rotations only."""


class RemovalWarning(RuntimeWarning):
    """Contact nodes of a run that starts from the end of another one lose other mass than there, so that its momentum
    and energy jump; the text says how much and what helps."""


class LockingWarning(RuntimeWarning):
    """The cells of a nearly incompressible body are too stiff: its deflections come out too small."""


class EnergyWarning(RuntimeWarning):
    """The energy error of a run exceeds 5 % of its largest kinetic and elastic energy; the text says what helps."""


class LayerWarning(RuntimeWarning):
    """The friction layers ended with an error of more than five times their tolerance; the text says what helps."""


class HourglassWarning(RuntimeWarning):
    """More than a tenth of the energy of deformation of a run was in hourglass modes of one-point hexahedra: its
    deflections come out wrong; the text says what helps."""


class SlaveWarning(RuntimeWarning):
    """The chosen slave of a pair of bodies does not suit its master.

    It is much stiffer, which makes the static solve slow, or its faces are too coarse for a curved or sharp master.
    """


class PlasticStepWarning(RuntimeWarning):
    """A point of a metal flowed by more than a plastic strain of 0.1 in a step, so that its new state is inaccurate."""
