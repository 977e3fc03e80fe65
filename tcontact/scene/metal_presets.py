"""Metals by name, with the sources of their constants.

| name | yield stress and source | checked |
|---|---|---|
| stainless-304 | Steinberg, Cochran and Guinan (1980); melting temperature after the paper (METHOD 5) | METHOD 5 |
| copper-ofhc | Johnson and Cook (1983); moduli of a data sheet | A, B, n, C, m against two copies of the table |
| copper-ofhc-half-hard | Steinberg, UCRL-MA-106439 (1996); c and T_f of handbooks | against a copy |
| aluminium-6061-t6 | Steinberg, UCRL-MA-106439 (1996); T_f the solidus of the alloy | against a copy |
| steel-4340 | Johnson and Cook, Engng Fract. Mech. 21, 31 (1985), RC 30 | A, B, n, C, m against a copy |
| tantalum | Steinberg, UCRL-MA-106439 (1996) | not checked: quoted from memory |

Steinberg's melting temperatures are those of his melting curve (1790 K for copper), larger than at ambient pressure;
the presets take those at ambient pressure, at which the exponential factor of the law ends the strength of the metal.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from ..base import validate
from ..friction_layer.metals import ALUMINIUM_6061, COPPER, STAINLESS_304, Metal
from ..friction_layer.steinberg_guinan import SteinbergGuinan
from .metals import ElastoPlastic, JohnsonCook


def _of_metal(metal: Metal, poisson: float, largest: float | None = None) -> ElastoPlastic:
    """Return the material of a metal of the friction layer; largest: largest yield stress [Pa]."""
    law = replace(metal.hardening_law, largest_yield_stress=largest)
    young = 2.0 * metal.shear_modulus * (1.0 + poisson)
    return ElastoPlastic(young, poisson, metal.density, law, specific_heat=metal.heat_capacity)


PRESETS: dict[str, ElastoPlastic] = {
    "stainless-304": _of_metal(STAINLESS_304, 0.29),
    "copper-ofhc": ElastoPlastic(
        124e9, 0.34, 8960.0, JohnsonCook(90e6, 292e6, 0.31, 0.025, 1.09, 1356.0), specific_heat=383.0
    ),
    "copper-ofhc-half-hard": _of_metal(COPPER, 0.34, 0.64e9),
    "aluminium-6061-t6": _of_metal(ALUMINIUM_6061, 0.33, 0.68e9),
    "steel-4340": ElastoPlastic(
        200e9, 0.29, 7830.0, JohnsonCook(792e6, 510e6, 0.26, 0.014, 1.03, 1793.0), specific_heat=477.0
    ),
    "tantalum": ElastoPlastic(
        2.0 * 69e9 * 1.34,
        0.34,
        16690.0,
        SteinbergGuinan(0.77e9, 10.0, 0.1, 1.45e-11, 1.3e-4, 1e-3, 3290.0, 300.0, 1.10e9),
        specific_heat=140.0,
    ),
}


def metal(name: str, **changes: Any) -> ElastoPlastic:
    """Return a metal by its name in `PRESETS`, such as "copper-ofhc", "steel-4340" or "tantalum".

    changes: arguments of `ElastoPlastic` that replace those of the preset. Constants of a metal vary from batch to
    batch: `tcontact.scene.metal_presets` names the source of each and what was checked. Raises `InputError`.
    """
    return replace(PRESETS[validate.choice("metal", name, PRESETS)], **changes)
