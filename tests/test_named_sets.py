"""Unknown sets and keys are refused by what names them: the part with its number and body, or the key."""

import re

import pytest

import tcontact as tc

MESH = tc.box_mesh((0.1, 0.1, 0.1), (2, 2, 2), "hex8")
LAW = tc.NeoHookean(1e6, 0.3, 1e3)
FIRST = tc.Spring("xmin", 1e3)
ENDS = {
    "a set of its body": ("top", "to = 'top': no such set of cube; use one of"),
    "a body": (("cub", "xmax"), "to = ('cub', 'xmax'): no such body; use one of base, cube"),
    "a set of another body": (("base", "top"), "to = 'top': no such set of base; use one of"),
}
PARTS = {
    "springs": tc.Spring("xmxx", 1e3),
    "point_masses": tc.PointMass("xmxx", 1.0),
    "supports": tc.Support("xmxx", "x"),
    "rigid_parts": tc.RigidPart("xmxx", mass=1.0),
}


@pytest.mark.parametrize("end", ENDS)
def test_the_end_of_a_spring(end):
    to, text = ENDS[end]
    base = tc.Body(MESH.translated((0.0, 0.0, 1.0)), LAW, name="base")
    cube = tc.Body(MESH, LAW, name="cube", springs=[FIRST, tc.Spring("xmax", 1e3, to=to)])
    with pytest.raises(tc.InputError, match=re.escape(f"Scene.bodies[1].springs[1].{text}")):
        tc.Scene([base, cube], duration=1.0)


@pytest.mark.parametrize("part", PARTS)
def test_the_set_of_a_part(part):
    wanted = f"Body.{part}[0].set = 'xmxx': no such set of cube; did you mean 'xmax'? use one of"
    with pytest.raises(tc.InputError, match=re.escape(wanted)):
        tc.Body(MESH, LAW, name="cube", **{part: [PARTS[part]]})


def test_an_unknown_key_of_a_scene_file_is_one_sentence(tmp_path):
    """The keys that are known follow in the sentence, or after the question for one that is nearly right."""
    path = tmp_path / "scene.toml"
    for key, text in (
        ("zzz", "unknown key; known are "),
        ("duratoin", "unknown key; did you mean 'duration'? Known are "),
    ):
        path.write_text(f"{key} = 1\n")
        with pytest.raises(tc.InputError, match=re.escape(text)):
            tc.load_scene(path)
