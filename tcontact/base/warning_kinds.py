"""Named warnings about a run, so that a script can ask for one, silence it or turn it into an error."""


class RotationWarning(RuntimeWarning):
    """A body or a wall turns so far that removal="normal" takes mass in directions that are normal no more."""


class LockingWarning(RuntimeWarning):
    """The cells of a nearly incompressible body are too stiff: its deflections come out too small."""


class EnergyWarning(RuntimeWarning):
    """A run ended with a large energy error."""


class LayerWarning(RuntimeWarning):
    """The friction layers ended with an error far above their tolerance."""
