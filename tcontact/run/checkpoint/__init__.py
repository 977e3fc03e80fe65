"""Checkpoints: everything that a bit-for-bit continuation of a run needs, two of them in its folder.

options       the options that a user hands in
contents      every array and number that the objects of a run hold, found by walking through them
fingerprint   the physics of a scene in plain words, to tell whether another scene is the same
store         the two files and which of them is good
keeper        the times at which one is written
"""

from .options import Checkpoint

__all__ = ["Checkpoint"]
