"""tcontact: dynamic contact and impact of deformable solids, on CPU and GPU."""

from pathlib import Path

_root = Path(__file__).resolve().parent.parent
if (_root / "kernels").is_dir() and (_root / "cases").is_dir():
    __path__.append(str(_root))  # a bare checkout: tcontact.kernels and tcontact.cases lie beside the package
