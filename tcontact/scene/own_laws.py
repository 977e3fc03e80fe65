"""Hyperelastic laws of users: a strain energy in plain arithmetic becomes a class of materials.

How it works. The energy is called once with symbols in place of numbers (kernels/language/traced_energy.py). From the
formula that it leaves behind come stress, tangent and the functions of implicit schemes, as sources of Taichi functions
(kernels/materials/from_energy.py). `law_checks.py` compares them with differences of the energy itself.
"""

from __future__ import annotations

import inspect
import keyword
from collections.abc import Callable, Mapping
from dataclasses import make_dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from ..base import validate
from ..base.errors import InputError
from ..device import runtime
from . import law_checks, materials, metals
from .materials import LameMaterial, Material

OWN: dict[str, type[OwnMaterial]] = {}  # the classes that `register_law` made, by their names


class OwnMaterial(LameMaterial):
    """Base class of the materials of registered laws.

    formula: text that differs for another energy; names: of the parameters as the user gave them; order: as the kernels
    have them; rest: finds its moduli (law_checks.py). Raises `InputError` for parameters with which the law is not free
    of stress at rest, or not stable there.
    """

    formula: ClassVar[str]
    names: ClassVar[tuple[str, ...]]
    order: ClassVar[tuple[str, ...]]
    rest: ClassVar[Any]

    if TYPE_CHECKING:

        def __init__(self, *given: float, **values: float) -> None:
            """Make a material of values of the parameters, then the density; each class has their names."""

    def __post_init__(self) -> None:
        for name in (*self.names, "density"):
            value = validate.number(name, getattr(self, name), low=0.0 if name == "density" else None)
            object.__setattr__(self, name, value)
        values = {name: getattr(self, name) for name in self.names}
        object.__setattr__(self, "_moduli", self.rest.moduli(type(self).__name__, values))

    @property
    def lame_lambda(self) -> float:
        """First Lame constant at small strains [Pa]; of an anisotropic law that of the mean over all directions."""
        return self._moduli.lam  # type: ignore[attr-defined]

    @property
    def lame_mu(self) -> float:
        """Shear modulus at small strains [Pa]; of an anisotropic law that of the mean over all directions."""
        return self._moduli.mu  # type: ignore[attr-defined]

    @property
    def parameters(self) -> tuple[float, ...]:
        """Constants for the kernels: those of the law, then the largest modulus of a plane wave [Pa]."""
        return (*(getattr(self, name) for name in self.order), self.wave_modulus)

    @property
    def wave_modulus(self) -> float:
        """Modulus of the stiffest plane wave at small strains [Pa]; lambda + 2 mu of an isotropic law."""
        return self._moduli.wave  # type: ignore[attr-defined]

    def __reduce__(self) -> tuple[Any, ...]:
        """Return what another process, which has registered the law too, makes the material from."""
        values = {name: getattr(self, name) for name in (*self.names, "density")}
        return _material, (type(self).__name__, self.formula, values)


def _material(name: str, formula: str, values: dict[str, float]) -> OwnMaterial:
    """Return a material of a registered law. Raises `InputError` where this process has no such law."""
    if name not in OWN or OWN[name].formula != formula:
        remedy = "is a law that this process has not registered; call tcontact.register_law where workers do so too,"
        raise InputError("material", name, f"{remedy} at the top of the program or in a module")
    return OWN[name](**values)


def register_law(name: str, energy: Callable[..., Any], parameters: Mapping[str, float]) -> type[OwnMaterial]:
    """Make a material of an own hyperelastic law from its strain energy alone; return its class.

    name: of the class, which scene files then know; energy(strain, **parameters): W per reference volume [J/m^3] as one
    smooth formula; parameters: their names, with values of a typical material, for which the law is checked here.

        def gent(strain, mu, limit, bulk):
            stretch = 1.0 - (strain.I1_bar - 3.0) / limit
            return -0.5 * mu * limit * np.log(stretch) + 0.5 * bulk * (strain.J - 1.0) ** 2

        Gent = tc.register_law("Gent", gent, {"mu": 4e5, "limit": 30.0, "bulk": 2e7})
        rubber = Gent(mu=3e5, limit=25.0, bulk=1e7, density=1100.0)
        body = tc.Body(mesh, rubber, contact="zmin")

    `strain` (a `tc.Strain`) has the 3x3 arrays H = grad u, F = I + H, C = F^t F, E = (C - I)/2 and the invariants J,
    I1, I2, I1_bar = J^(-2/3) I1, I2_bar = J^(-4/3) I2. The formula takes + - * / ** @ and NumPy's log, log1p, log2,
    log10, exp, expm1, sqrt, sinh, cosh, trace and the like, without `if`, `abs`, `max`. It may be anisotropic: of a
    fibre along the unit vector a, a @ strain.C @ a is the square of its stretch. For principal stretches see `Ogden`.

    Write the formula as in a textbook. Stress, energy and tangent are derived exactly, in a form in which small strains
    keep their digits (a strain of 1e-9 too). Powers with whole exponents, halves and thirds are cheaper than others.
    A parameter k of which k/2 (J - 1)^2 is all that W has makes formulation="mean-dilatation" and "node-averaged"
    possible. Where the argument of a logarithm or a root, or a divisor, passes 0, a run stops as for inverted cells.
    Implicit schemes take an energy of C, E, J and the invariants, all but those with discrete stresses.

    Checked at once: values against those of the function for numbers, stress against its derivative by complex steps,
    tangent against that of the stress, no change under rotations; and here and for every material no stress without
    strain and a positive definite stiffness there, from which the Lame constants and the wave speed of it come.
    The same law may be registered again, which returns the same class; another formula needs another name, since
    kernels are known by it. A scene file or a checkpoint with the law is read after it was registered; `resume` refuses
    another formula. Raises `InputError` naming what is wrong.
    """
    field = "register_law.name"
    taken = [kind.__name__ for kind in (*materials.LAWS.values(), metals.ElastoPlastic)]
    if not isinstance(name, str) or not name.isidentifier() or keyword.iskeyword(name):
        raise InputError(field, name, "give the name of a class, such as 'Gent'")
    runtime.load()
    from ..kernels.language.expressions import NotPlain  # kernels, which a scene without own laws does not load
    from ..kernels.language.formula import Formula
    from ..kernels.materials import LAWS
    from ..kernels.materials.from_energy import law_of

    if name in taken or (name in LAWS and name not in OWN):
        raise InputError(field, name, "the program has a law of this name; give another one")
    values = _parameters(energy, parameters)
    try:
        formula = Formula(energy, tuple(values))
        law_checks.check(formula, values)
        order = law_checks.volumetric_first(formula, values)
        own = law_of(name, energy, order)
    except NotPlain as error:
        raise InputError("register_law.energy", energy, str(error)) from error
    if name in OWN:
        if OWN[name].formula == own.formula and OWN[name].names == tuple(values):
            return OWN[name]
        remedy = "is registered with another formula, for which kernels may be compiled: give the new one another name,"
        raise InputError(field, name, f"{remedy} or start Python again")
    parts = {
        "__doc__": inspect.getdoc(energy) or f"A material of the registered law {name!r}.",
        "__module__": getattr(energy, "__module__", __name__),
        "law": name,
        "word": name,
        "volumetric": law_checks.is_volumetric(formula, values, order[0]),
        "formula": own.formula,
        "names": tuple(values),
        "order": tuple(order),
        "rest": law_checks.Rest(formula),
    }
    made = make_dataclass(name, [*((one, float) for one in values), ("density", float)],
                          bases=(OwnMaterial,), namespace=parts, frozen=True)  # fmt: skip
    made(**values, density=1.0)
    LAWS[name] = own.law
    OWN[name] = made
    return made


def _parameters(energy: Any, given: Any) -> dict[str, float]:
    """Return the names and typical values of the parameters of an energy. Raises `InputError`."""
    if not callable(energy):
        raise InputError("register_law.energy", energy, "give a function energy(strain, ...)")
    remedy = "give the names of the parameters of `energy` with values of a typical material, {'mu': 4e5, ...}"
    if not isinstance(given, Mapping) or not given or not all(isinstance(name, str) for name in given):
        raise InputError("register_law.parameters", given, remedy)
    values = {name: validate.number(f"register_law.parameters[{name!r}]", one) for name, one in given.items()}
    for name in values:
        if not name.isidentifier() or keyword.iskeyword(name) or name.startswith("_") or name in _reserved():
            raise InputError("register_law.parameters", name, "is a name that every material has; give it another one")
    try:
        inspect.signature(energy).bind(None, **values)
    except TypeError as error:
        text = f"energy(strain, {', '.join(values)}) is what will be called: {error}"
        raise InputError("register_law.parameters", list(values), text) from error
    except ValueError:  # a callable without a signature
        pass
    return values


def _reserved() -> set[str]:
    return {*dir(OwnMaterial), *Material.__annotations__, *OwnMaterial.__annotations__}
