"""Checkpoints: everything that a bit-for-bit continuation of a run needs, two of them in its folder.

options       what a user asks for
contents      what a run consists of: every array and number that its objects hold, found by walking through them
fingerprint   the physics of a scene in plain words, to tell whether another scene is the same
store         the two files and which of them is good
keeper        when to write one
"""

from .options import Checkpoint

__all__ = ["Checkpoint"]
