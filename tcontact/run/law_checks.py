"""Check the material laws of a scene against those that the kernels have."""

from __future__ import annotations

from typing import Any

from ..base.errors import InputError
from ..scene.scene import Scene
from ..schemes import IMPLICIT


def check_laws(scene: Scene, scheme: Any) -> None:
    """Refuse a law that the kernels do not have, or not for this scheme, and wrong parameters. Raises `InputError`."""
    from ..kernels.cells.implicit_rules import has_rule  # imports Taichi, as the next ones do
    from ..kernels.materials import LAWS

    for index, body in enumerate(scene.bodies):
        for block in body.blocks:
            field = f"Scene.bodies[{index}].material"
            field += "" if block.region is None else f"[{block.region!r}]"
            name, values = block.material.law, block.material.parameters
            law = LAWS.get(name)
            if law is None:
                remedy = f"the kernels have {', '.join(LAWS)}; tcontact.register_law adds one"
                raise InputError(f"{field}.law", name, remedy)
            if len(values) != len(law.parameters):
                remedy = f"the law {name!r} takes {len(law.parameters)}, {', '.join(law.parameters)}; give a value for"
                raise InputError(f"{field}.parameters", values, f"{remedy} each")
            if scheme.implicit and not has_rule(law, scheme.stress):
                have = ", ".join(known for known, one in LAWS.items() if has_rule(one, scheme.stress))
                others = [kind.__name__ for kind in IMPLICIT if has_rule(law, kind.stress)]
                remedy = f"implicit schemes have {have} for steps of {type(scheme).__name__}; use one of them, or a"
                remedy += f" scheme that takes {name}: {', '.join([*others, 'CentralDifference'])}"
                raise InputError(f"{field}.law", name, remedy)
