"""The laws of materials: one file for every law, found by its name (`law` says what such a file has)."""

from importlib import import_module
from pkgutil import iter_modules

from .law import Law

LAWS: dict[str, Law] = {
    module.name: law
    for module in iter_modules(__path__)
    if (law := getattr(import_module(f"{__name__}.{module.name}"), "LAW", None)) is not None
}
