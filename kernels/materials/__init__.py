"""The laws of materials: a file ends with `LAW`, named as the file, or with several `LAWS` by name (see `law`)."""

from importlib import import_module
from pkgutil import iter_modules

from .law import Law

LAWS: dict[str, Law] = {}
for module in iter_modules(__path__):
    found = import_module(f"{__name__}.{module.name}")
    LAWS |= {module.name: found.LAW} if hasattr(found, "LAW") else getattr(found, "LAWS", {})
