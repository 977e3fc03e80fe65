"""Every figure of the tables in README.md and docs/NUMBERS.md that a run of a case makes."""

from __future__ import annotations

from .rows import Report, Row

BENCH = "bench --kinds hex8,hex8-turned,hex8-skew,hex8-distorted,hex8-reduced,tet4 --laws neo-hookean --sizes 16,32"
METHODS = "massless-normal,massless-penalty-10,penalty-1,penalty-10,impulse"
STUDY = f"study bar-impact --steps .9,.45 --methods {METHODS}"
HARD_CASES = (
    "nu-0.4999-full",
    "svk-beyond-its-limit",
    "sliver-tets-extreme",
    "plate-both-faces",
    "hinged-contact-nodes",
    "corner-first",
    "spinning-cube",
    "three-walls",
    "contact-on-a-step",
    "step-1.3",
    "penalty-1e8-massless",
    "80-bounces",
    "random-rotation",
)
HARD = f"study hard-cases --methods {','.join(HARD_CASES)}"
COMPARE = "run cube-impact --set compare=true"
CONTACTS = ("massless", "massless + penalty", "ordinary mass + penalty")
BEAM = "run incompressible-beam --set compare=true --set duration=6"
STIFF = "run incompressible-beam --set compare=true --set ratio=1000 --set duration=4"
CONSERVING = ("gonzalez", "discrete-gradient")
LAYER = "run friction-layer"
IMPLICIT = "run cube-impact --set cells=8 --set penalty=10 --set scheme=discrete-gradient"


def _each(labels: tuple[str, ...], name: str) -> tuple[str, ...]:
    """Return the places of the same figure in every run of a comparison."""
    return tuple(f"figures > {label} > {name}" for label in labels)


def _conserved(report: Report) -> float:
    """Return the largest energy error of the conserving schemes in a comparison."""
    return max(report["figures"][name]["energy_error_max"] for name in CONSERVING)


RUNS = (
    Row(
        "run bar-impact",
        "force, relative L2 error; rms of its plateau; running impulse",
        "{:.1e}; {:.1e}; {:.1e}",
        ("checks > force, relative L2 error", "checks > plateau rms", "checks > running impulse error"),
        note="160 hexes, cfl 0.9",
        short=True,
        quick=True,
    ),
    Row(
        "run bar-impact",
        "largest force / plateau; releases; energy error",
        "{:.2f}; {:.0f}; {:.1e}",
        ("smoothness > peak_over_plateau", "checks > releases", "energy_error_max"),
        quick=True,
    ),
    Row(
        "run bar-impact --set kind=tet4",
        "force, relative L2 error; rms of its plateau; energy error",
        "{:.1e}; {:.1e}; {:.1e}",
        ("checks > force, relative L2 error", "checks > plateau rms", "energy_error_max"),
        quick=True,
    ),
    Row(
        "run bouncing-bar",
        "impulse of a bounce, largest error; energy error",
        "{:.1e}; {:.1e}",
        ("checks > impulse of a bounce, error", "energy_error_max"),
        note="80 hexes, 4 contacts",
        quick=True,
    ),
    Row(
        "run wall-shock",
        "plateau; shock speed; energy error",
        "{:.3f}; {:.3f}; {:.1e}",
        ("checks > plateau / jump conditions", "checks > shock speed / jump conditions", "energy_error_max"),
        note="Mach 0.1, over the jump conditions",
        quick=True,
    ),
    Row(
        "run cube-impact",
        "energy error; momentum against impulses",
        "{:.1e}; {:.0e}",
        ("energy_error_max", "checks > momentum = impulses"),
        note="neo-Hookean",
        short=True,
        quick=True,
    ),
    Row(
        "run cube-impact --set law=linear --set cfl=0.8",
        "restitution; mean force / (rho c v A); energy error",
        "{:.3f}; {:.3f}; {:.1e}",
        ("checks > restitution", "checks > mean force / (rho c v A)", "energy_error_max"),
        quick=True,
    ),
    Row(
        "run cube-impact --set formulation=reduced",
        "energy error; hourglass energy, at most",
        "{:.1e}; {:.1e}",
        ("energy_error_max", "hourglass_share_max"),
    ),
    Row(
        "run cube-impact --set pitch=45",
        "energy error; largest overlap / size",
        "{:.1e}; {:.0e}",
        ("energy_error_max", "checks > overlap / size"),
        note="edge first",
    ),
    Row(
        "run cube-impact --set yaw=45 --set pitch=54.7356",
        "energy error; largest overlap / size",
        "{:.1e}; {:.0e}",
        ("energy_error_max", "checks > overlap / size"),
        note="corner first",
    ),
    Row(
        COMPARE,
        "changes of the force / (2 largest force)",
        "{:.1f}, {:.1f}, {:.1f}",
        _each(CONTACTS, "force_changes"),
        note="massless, with penalty, ordinary mass + penalty",
    ),
    Row(
        COMPARE,
        "the same of a node's pressure",
        "{:.1f}, {:.1f}, {:.0f}",
        _each(CONTACTS, "nodal_variation"),
    ),
    Row(COMPARE, "checkerboard of the pressure", "{:.3f}, {:.3f}, {:.2f}", _each(CONTACTS, "checkerboard")),
    Row(COMPARE, "energy error", "{:.1e}, {:.1e}, {:.2f}", _each(CONTACTS, "energy_error_max")),
    Row(
        "run pressure-shear",
        "pressure; shear; friction work in slip",
        "{:.3f}; {:.3f}; {:.3f}",
        ("checks > pressure / (rho c_d v_n)", "checks > shear / exact", "checks > friction work / exact"),
        note="80 hexes, exact: 1",
        short=True,
        quick=True,
    ),
    *(
        Row(
            f"run pressure-shear --set sideways={speed}",
            "friction work in slip",
            "{:.3f}",
            ("checks > friction work / exact",),
            note=f"{times} times the speed at which it just sticks",
        )
        for times, speed in (("1.05", 0.3929), ("1.1", 0.4116), ("1.3", 0.4864), ("2", 0.7483))
    ),
    Row(
        "run pressure-shear --set friction=0.7",
        "kinetic energy lost where it sticks; energy error",
        "{:.1e}; {:.1e}",
        ("checks > lost while it sticks / kinetic energy", "energy_error_max"),
    ),
    Row(
        "run sliding-block",
        "stop distance; energy error",
        "{:.3f}; {:.1e}",
        ("checks > stop distance / rigid", "energy_error_max"),
        note="rigid block: 1",
        short=True,
        quick=True,
    ),
    Row("run sliding-block --set motion=slide", "acceleration", "{:.4f}", ("checks > acceleration / rigid",)),
    Row(
        "run sliding-block --set motion=hold",
        "drift / length",
        "{:.0e}",
        ("checks > drift, second half / length",),
    ),
    Row(
        "run rolling-cylinder",
        "error of the rolling speed; of the friction work; energy error",
        "{:.1e}; {:.1e}; {:.0e}",
        ("checks > rolling speed, error", "checks > friction work, error", "energy_error_max"),
        note="against a rigid cylinder",
        short=True,
    ),
    Row(
        LAYER,
        "surface temperature / its rise; shear stress",
        "{:.1e}; {:.1e}",
        ("checks > 34 m/s: temperature error / rise, 0.1..0.6 us", "checks > 34 m/s: tau error, 0.1..0.6 us"),
        note="34 m/s, error against an independent code",
        short=True,
        quick=True,
    ),
)

IMPLICIT_RUNS = (
    Row(
        BEAM,
        "trapezoidal and midpoint rule: stopped with ten times the energy after [s]",
        "{:.1f}, {:.1f}",
        ("figures > trapezoidal > time", "figures > midpoint > time"),
        note="lambda/mu = 10, 59 stable steps at a time",
    ),
    Row(
        BEAM,
        "scheme of the paper, Hilber-Hughes-Taylor: energy at the end / at the start",
        "{:.2f}, {:.2f}",
        ("figures > paper-implicit > energy_end", "figures > hilber-hughes-taylor > energy_end"),
    ),
    Row(BEAM, "conserving schemes: energy error", "{:.0e}", (_conserved,)),
    Row(
        STIFF,
        "trapezoidal and midpoint rule: stopped after [s]",
        "{:.1f}, {:.1f}",
        ("figures > trapezoidal > time", "figures > midpoint > time"),
        note="lambda/mu = 1000",
    ),
    Row(STIFF, "conserving schemes: energy error", "{:.0e}", (_conserved,)),
    Row(
        "run tumbling-block",
        "energy error; change of angular momentum",
        "{:.0e}; {:.0e}",
        ("energy_error_max", "checks > change of angular momentum"),
        note="free flight with spin",
        quick=True,
    ),
    *(
        Row(
            f"{IMPLICIT} --set contact={contact} --set dt={dt}",
            f"largest contact force [kN], {mass} mass",
            "{:.2f}",
            (lambda report: 1e-3 * report["contact_force_max"],),
        )
        for mass, contact in (("redistributed", "massless"), ("ordinary", "penalty"))
        for dt in ("4e-4", "1e-4", "2.5e-5")
    ),
)
