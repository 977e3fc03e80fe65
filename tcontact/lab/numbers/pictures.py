"""The pictures of README.md and docs/NUMBERS.md, from the runs that they show."""

from __future__ import annotations

from pathlib import Path

from ...base.errors import OutputError
from . import register
from .reports import Reports

CUBE = "run cube-impact --frames 60"
PRESSED = 1.2e-3  # time [s] at which the cube is pressed together
FROM_RUNS = {
    "comparison.png": (register.COMPARE, "comparison.png"),
    "bar-impact-study.png": (register.STUDY, "study.png"),
    "beam-energy.png": (register.BEAM, "comparison.png"),
    "penetration-energy.png": ("run penetration-energy --set compare=true", "comparison.png"),
}


def draw(root: Path, reports: Reports) -> list[Path]:
    """Make the pictures in docs/ below `root` again; return them. Raises `OutputError` if a run left none."""
    from ...show.render import render_picture

    made = []
    for name, (command, picture) in FROM_RUNS.items():
        reports(command)
        drawn = reports.folder(command) / picture
        if not drawn.exists():
            raise OutputError(f"`tcontact {command}` left no {picture}; run it again")
        made.append(_small([drawn], root / "docs" / name))
    reports(CUBE)
    folder = reports.folder(CUBE)
    pressed = render_picture(
        folder / "result.vtkhdf", folder / "pressed.png", PRESSED, field="von_mises", title="cube-impact"
    )
    made.append(_small([Path(pressed), folder / "contact-force.png"], root / "docs" / "cube-impact.png"))
    return made


def _small(parts: list[Path], path: Path) -> Path:
    """Put pictures beside each other, 1400 pixels wide at most, with a palette of 256 colours."""
    from PIL import Image

    pictures = [Image.open(part).convert("RGB") for part in parts]
    height = min(picture.height for picture in pictures)
    scaled = [picture.resize((round(picture.width * height / picture.height), height)) for picture in pictures]
    sheet = Image.new("RGB", (sum(picture.width for picture in scaled), height), "white")
    left = 0
    for picture in scaled:
        sheet.paste(picture, (left, 0))
        left += picture.width
    if sheet.width > 1400:
        sheet = sheet.resize((1400, round(sheet.height * 1400 / sheet.width)))
    sheet.quantize(256, Image.Quantize.MAXCOVERAGE, kmeans=2).save(path, optimize=True)
    return path
