"""The site of the documents: it builds strictly, its links lead somewhere, and its scripts run, with coarse meshes."""

import html.parser
import json
import os
import re
import runpy
import subprocess
import sys
import urllib.parse
import warnings
from pathlib import Path

import pytest

import tcontact as tc

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
COARSE = {  # scripts: what is replaced, so that they run in seconds
    "tutorial.py": {"(12, 12, 6)": "(6, 6, 3)", "cells=4,": "cells=2,", "duration=4e-3": "duration=5e-4"},
    "gallery/bowl.py": {"CELLS, GRID, DURATION = 8, 96, 0.03": "CELLS, GRID, DURATION = 2, 48, 0.018"},
    "gallery/tyre.py": {"CELLS, DURATION = 48, 0.25": "CELLS, DURATION = 12, 0.01"},
    "gallery/ranks.py": {"(12, 12, 96)": "(2, 2, 8)"},
    "gallery/phone.py": {"(80, 40, 6), 2e-3": "(12, 6, 3), 2e-4"},
}


@pytest.mark.parametrize("name", COARSE)
def test_scripts_of_the_site_run(name, tmp_path, monkeypatch, capsys):
    text = (DOCS / name).read_text(encoding="utf-8")
    for old, new in COARSE[name].items():
        assert old in text, old
        text = text.replace(old, new)
    script = tmp_path / Path(name).name
    script.write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    with warnings.catch_warnings():
        warnings.filterwarnings("error", module="meshio")  # of a bad surface
        names = runpy.run_path(str(script))
    assert names["result"].reason == "finished"
    assert names["result"].history["energy_error"].max() < 1e-2
    assert abs(names["result"].history["contact_force"]).max() > 0.0
    assert "largest force" in capsys.readouterr().out


class Page(html.parser.HTMLParser):
    """Anchors of a page, and what it refers to."""

    def __init__(self, text):
        super().__init__()
        self.anchors, self.links = set(), []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        self.anchors |= {given[key] for key in ("id", "name") if given.get(key)}
        self.links += [given[key] for key in ("href", "src") if given.get(key)]


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The pages by their paths below the site."""
    pytest.importorskip("mkdocs", reason="mkdocs-material is not installed: pip install 'tcontact[docs]'")
    pytest.importorskip("mkdocstrings", reason="mkdocstrings is not installed: pip install 'tcontact[docs]'")
    out = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "-d", str(out)]
    environment = os.environ | {"NO_MKDOCS_2_WARNING": "1"}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-3000:]
    return out, {path: Page(path.read_text(encoding="utf-8")) for path in out.rglob("*.html")}


def test_every_link_of_the_site_leads_somewhere(site):
    out, pages = site
    broken = []
    for path, page in pages.items():
        for link in page.links:
            parts = urllib.parse.urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else path
            target = out / parts.path.lstrip("/") if parts.path.startswith("/") else target
            anchored = not parts.fragment or target not in pages or parts.fragment in pages[target].anchors
            if not target.exists() or not anchored:
                broken.append(f"{path.relative_to(out)}: {link}")
    assert not broken, "\n".join(broken)
    assert len(pages) > 25


def test_the_site_fetches_nothing_from_other_servers(site):
    for path in site[1]:
        text = path.read_text(encoding="utf-8")
        foreign = re.findall(r'<(?:script|img|link|iframe)[^>]*(?:src|href)="(https?:[^"]*)"', text)
        assert not foreign, (path, foreign)


def test_scripts_stand_in_the_pages(site):
    out, _ = site
    for path in (out / "tutorial.html", *sorted((out / "gallery").glob("*.html"))):
        text = re.sub("<[^>]*>", "", path.read_text(encoding="utf-8"))
        assert "--8" not in text.replace(" ", ""), path
        assert path.name == "index.html" or "import tcontact" in text, path


def test_the_reference_explains_every_public_name(site):
    explained = set().union(*(page.anchors for path, page in site[1].items() if path.parent.name == "api"))
    names = [name for name in tc.__all__ if name[0].isupper() and not name.endswith("Warning")]
    names += [name for name in tc.__all__ if name[0].islower() and callable(getattr(tc, name))]
    assert not [name for name in names if f"tcontact.{name}" not in explained]


def test_every_case_and_command_has_a_place_in_the_site(site):
    from tcontact import cases

    out, pages = site
    assert set(cases.names()) <= pages[out / "cases.html"].anchors
    text = (out / "commands.html").read_text(encoding="utf-8")
    for command in (
        "list",
        "run",
        "resume",
        "study",
        "info",
        "render",
        "report",
        "export",
        "bench",
        "numbers",
        "doctor",
    ):
        assert f"usage: tcontact {command}" in text


def test_every_scene_of_the_gallery_has_its_page_and_pictures():
    gallery = runpy.run_path(str(DOCS / "gallery" / "make.py"))["GALLERY"]
    assert len(gallery) >= 12
    for name, shown in gallery.items():
        assert (ROOT / shown.script).exists()
        page = (DOCS / "gallery" / f"{name}.md").read_text(encoding="utf-8")
        assert shown.title in page
        for picture in (f"{name}.webp", f"{name}-film.webp"):
            assert picture in page
            assert (DOCS / "gallery" / picture).stat().st_size > 3000


def test_a_page_of_the_gallery_shows_what_its_script_warns_of(tmp_path):
    make = runpy.run_path(str(DOCS / "gallery" / "make.py"))
    for said in ([], ["flutter: look at contact_force", "another"]):
        (tmp_path / "summary.json").write_text(json.dumps({"steps": 5, "wall_s": 1.0, "warnings": said}))
        page = make["page"]("tyre", make["GALLERY"]["tyre"], 1.0, "printed", tmp_path)
        assert all(text in page for text in said)
        assert ("as warnings" in page) == bool(said)
    assert "flutter" in (DOCS / "gallery" / "tyre.md").read_text(encoding="utf-8")
