"""Classes of warnings about a run, so that a script can select, silence or raise each."""


class RotationWarning(RuntimeWarning):
    """A body or a wall turns so far that removal="normal" removes mass in directions that are no longer normal."""


class LockingWarning(RuntimeWarning):
    """The cells of a nearly incompressible body are too stiff: its deflections come out too small."""


class EnergyWarning(RuntimeWarning):
    """A run ended with a large energy error."""


class LayerWarning(RuntimeWarning):
    """The friction layers ended with an error far above their tolerance."""


class SlaveWarning(RuntimeWarning):
    """The chosen slave of a pair of bodies is much stiffer than its master, which makes the static solve slow."""


class PlasticStepWarning(RuntimeWarning):
    """A point of a metal flowed so far in a step that its new state is inaccurate."""
