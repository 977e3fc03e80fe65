"""A mesh that makes its arrays of all nodes and cells where they are first read, from something smaller."""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np

from .mesh import Mesh, contents

Own = TypeVar("Own", bound="LateMesh")


class LateMesh(Mesh):
    """A `Mesh` whose `nodes` and `cells` follow from other data; they are kept until `release`."""

    def __new__(cls, *arrays: Any, **named: Any) -> Any:
        """Make a `Mesh` of arrays, as of such a mesh with some of them replaced."""
        return Mesh(*arrays, **named)

    @classmethod
    def _without_arrays(cls: type[Own], kind: str, *sets: Any, **more: Any) -> Own:
        """Make a mesh of its sets, which are known to be valid, and what its arrays follow from."""
        mesh = object.__new__(cls)
        known = contents(np.zeros((0, 3)), np.zeros((0, 0), dtype=np.int64), kind, *sets)
        del known["nodes"], known["cells"]
        mesh.__dict__.update(known, **more)
        return mesh

    def release(self) -> None:
        """Forget arrays of all nodes or cells, which are made again where they are read."""
        for name in ("nodes", "cells", "blocks", "repeated", "_volumes"):
            self.__dict__.pop(name, None)
