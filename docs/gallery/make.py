"""Makes the pages of the gallery with their pictures, films, numbers and times: python docs/gallery/make.py [NAME ..]

Every scene runs in a process of its own, below runs/gallery; its page and pictures then take the place of the old ones
beside this file. A scene is a case of the program, or a script of this folder or of the one above.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
from PIL import Image

import tcontact as tc
from tcontact.lab.bench.collect import machine
from tcontact.show.render import Camera, render_frames

HERE = Path(__file__).resolve().parent
RUNS = Path("runs/gallery")
FILM, PICTURES = (480, 360), 40  # size [pixel] and number of pictures of a film


class Shown(NamedTuple):
    """A scene of the gallery: where its script stands, where its run goes, and what its page says.

    words: of `tcontact run` for a case; "" for a script. folder: of the run of a script. camera: direction to the eye.
    ranks: processes of a script, which then prints the same on one.
    """

    title: str
    script: str
    about: str
    words: str = ""
    folder: str = ""
    camera: tuple[float, float, float] | None = None
    ranks: int = 1
    field: str = "von_mises"


GALLERY = {
    "cube-impact": Shown(
        "A rubber cube strikes a wall",
        "cases/cube_impact.py",
        "The first case of every contact code. The contact force rises without an overlap of cube and wall and without"
        " chatter; the impulse is that of the change of momentum to rounding.",
        "cube-impact",
    ),
    "phone": Shown(
        "A case for a phone falls on one corner",
        "docs/gallery/phone.py",
        "A thin shell of 48 000 tetrahedra lands on its corner at 3 m/s. Its cells are nearly incompressible: the"
        " node-averaged formulation, which keeps them from locking, is chosen by itself.",
        folder="runs/phone",
    ),
    "tutorial": Shown(
        "A punch strikes a bumper",
        "docs/tutorial.py",
        "Two bodies that touch each other, with friction: the scene of the [tutorial](../tutorial.md).",
        folder="runs/punch",
    ),
    "bowl": Shown(
        "A ball in a bowl out of an STL file",
        "docs/gallery/bowl.py",
        "An obstacle can be any closed surface. It is sampled as a signed distance once, so that contact with it costs"
        " no more than contact with a plane.",
        folder="runs/bowl/run",
        camera=(0.4, -0.8, 1.2),
    ),
    "tyre": Shown(
        "A tyre with a rigid rim lands and rolls",
        "docs/gallery/tyre.py",
        "The inner surface of the tyre is tied to a rigid rim with a mass of its own. Friction turns the tyre until it"
        " rolls; the spin of the rim and the work of friction are in the history.",
        folder="runs/tyre",
    ),
    "taylor-bar": Shown(
        "Taylor's bar: copper at 190 m/s",
        "cases/taylor_bar.py",
        "A copper bar strikes a rigid wall and flows. Length and foot are compared with published values; every joule"
        " of plastic work is in the ledger.",
        "taylor-bar",
        field="plastic_strain",
    ),
    "two-cubes": Shown(
        "Two cubes with turned meshes",
        "cases/two_cubes.py",
        "Bodies that strike each other obliquely with meshes that do not match. Linear and angular momentum are kept.",
        "two-cubes",
    ),
    "stack": Shown(
        "A stack comes to rest",
        "cases/stack.py",
        "Five blocks are dropped on each other and carry their weight: many pairs in contact at once.",
        "stack",
    ),
    "metal-slide": Shown(
        "Steel slides on steel, with its friction layers",
        "cases/metal_slide.py",
        "Two blocks of steel slide under 1.3 GPa. A thin layer of metal on each contact face heats, softens and limits"
        " the friction; its heat flows into the blocks.",
        "metal-slide --set speed=340",
    ),
    "two-materials": Shown(
        "A bar of two materials",
        "cases/two_materials.py",
        "A wave goes partly through the joint between two materials and partly back, as the exact solution says.",
        "two-materials",
    ),
    "incompressible-beam": Shown(
        "A swinging beam under an implicit scheme",
        "cases/incompressible_beam.py",
        "A nearly incompressible beam swings in large steps: the energy is kept to rounding, where usual schemes gain"
        " or lose it.",
        "incompressible-beam",
    ),
    "ranks": Shown(
        "A rubber fender strikes a pier, on several processes",
        "docs/gallery/ranks.py",
        "The same script runs on one process and under `mpiexec` on several, which share the cells; below stands what"
        " it prints on two and on one. [Several processes](../SCALING.md) tells how.",
        folder="runs/ranks",
        ranks=2,
    ),
    "striker": Shown(
        "A free rigid ball falls on rubber",
        "cases/striker.py",
        "A rigid ball with a mass of its own strikes a rubber block and bounces off; contact places it exactly.",
        "striker",
    ),
}


def main(names: list[str]) -> None:
    """Make the pages of some scenes, or of all, and the page that lists them."""
    for name in names or GALLERY:
        shown = GALLERY[name]
        base = RUNS.resolve() / name
        base.mkdir(parents=True, exist_ok=True)
        took, printed = run(name, shown, base)
        if shown.ranks > 1:
            alone = run(name, shown._replace(ranks=1, folder="runs/ranks"), base.parent / f"{name}-alone")[1]
            printed = f"$ mpiexec -n {shown.ranks} python {Path(shown.script).name}\n{printed}"
            printed += f"\n$ python {Path(shown.script).name}\n{alone}"
        folder = base / (shown.folder or "run")
        result = tc.open_result(folder)
        pictures(name, shown, result, folder)
        (HERE / f"{name}.md").write_text(page(name, shown, took, printed, folder), encoding="utf-8")
        print(f"{name}: {took:.0f} s", flush=True)
    (HERE / "index.md").write_text(listing(), encoding="utf-8")


def run(name: str, shown: Shown, base: Path) -> tuple[float, str]:
    """Run a scene in a process of its own with an empty kernel cache; return its seconds and what it printed."""
    root = HERE.parent.parent
    if shown.words:
        command = ["-m", "tcontact", "run", *shown.words.split(), "--out", str(base / "run"), "--force", "--quiet"]
    else:
        (base / shown.folder / "result.vtkhdf").unlink(missing_ok=True)
        command = [str(root / shown.script)]
    base.mkdir(parents=True, exist_ok=True)
    words = ["mpiexec", "-n", str(shown.ranks)] if shown.ranks > 1 else []
    words += [sys.executable, "-W", "ignore", *command]
    with tempfile.TemporaryDirectory() as cache:
        paths = os.pathsep.join(filter(None, (str(root), os.environ.get("PYTHONPATH"))))
        environment = os.environ | {"TI_OFFLINE_CACHE_FILE_PATH": cache, "PYTHONPATH": paths}
        start = time.perf_counter()
        done = subprocess.run(words, cwd=base, env=environment, capture_output=True, text=True)
        took = time.perf_counter() - start
    if done.returncode not in (0, 1):
        raise SystemExit(f"{name}: {done.stderr}")
    return took, "\n".join(
        line for line in done.stdout.splitlines() if not line.startswith(("  ", "terms:", "[Taichi]"))
    )


def pictures(name: str, shown: Shown, result: tc.StoredResult, folder: Path) -> None:
    """Make the picture of the largest force, or of the largest stress, and the film."""
    camera = Camera(shown.camera) if shown.camera else None
    frames = result.frames
    sizes = [np.abs(frames.frame(k).cell_data[shown.field]).max() for k in range(len(frames))]
    if shown.field == "plastic_strain":
        sizes = list(range(len(frames)))
    when = float(frames.times[int(np.argmax(sizes))])
    picture = result.render(None, time=when, field=shown.field, camera=camera, title=shown.title)
    Image.fromarray(picture).resize((720, 540), Image.Resampling.LANCZOS).save(
        HERE / f"{name}.webp", quality=80, method=6
    )
    with tempfile.TemporaryDirectory() as place:
        drawn = render_frames(
            result.frames, place, field=shown.field, size=FILM, camera=camera, animation=False, title="", video=False
        )
        paths = [path for path in drawn if path.name.startswith("frame-")]
        chosen = [paths[k] for k in sorted({round(k) for k in np.linspace(0, len(paths) - 1, PICTURES)})]
        images = [Image.open(path).convert("RGB") for path in chosen]
        images[0].save(
            HERE / f"{name}-film.webp",
            save_all=True,
            append_images=images[1:],
            duration=120,
            loop=0,
            quality=45,
            method=6,
        )


def page(name: str, shown: Shown, took: float, printed: str, folder: Path) -> str:
    """Return the page of a scene."""
    about = machine()
    where = f"{about['processor']}, {about['cores']} cores"
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    command = f"tcontact run {shown.words}" if shown.words else f"python {Path(shown.script).name}"
    command = f"mpiexec -n {shown.ranks} {command}" if shown.ranks > 1 else command
    parts = [
        f"# {shown.title}",
        shown.about,
        f"![{shown.title}]({name}.webp)",
        f"`{command}` took {took:.0f} s with an empty kernel cache{', pictures included' if shown.words else ''}"
        f" ({where}); the {summary['steps']} steps themselves {summary['wall_s']:.2g} s.",
    ]
    if summary.get("checks"):
        parts.append("## Checks")
        rows = [f"| {one['name']} | {_short(one['value'])} | {one['bound']} |" for one in summary["checks"]]
        parts.append("\n".join(["| quantity | value | bound |", "|---|---|---|", *rows]))
    elif printed:
        parts += ["## What it prints", f"```text\n{printed}\n```"]
        if summary["warnings"]:
            parts += ["and as warnings", "```text\n" + "\n".join(summary["warnings"]) + "\n```"]
    parts += ["## Film", f"![Film: {shown.title}]({name}-film.webp)", "## The script"]
    parts.append(f'```py\n--8<-- "{shown.script}"\n```')
    return "\n\n".join(parts) + "\n"


def listing() -> str:
    """Return the page that lists the scenes."""
    parts = [
        "# Gallery",
        "Each page has the whole script, its pictures and its numbers. `python docs/gallery/make.py` makes",
    ]
    parts[-1] += " them again."
    rows = [f"| [![{one.title}]({name}.webp){{ width=260 }}]({name}.md) | **[{one.title}]({name}.md)**<br>{one.about} |"
            for name, one in GALLERY.items()]  # fmt: skip
    parts.append("\n".join(["| | |", "|---|---|", *rows]))
    return "\n\n".join(parts) + "\n"


def _short(value: object) -> str:
    """Return a value of a check in few digits."""
    return f"{value:.3g}" if isinstance(value, float) else str(value)


if __name__ == "__main__":
    main(sys.argv[1:])
