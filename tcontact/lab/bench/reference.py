"""The force again, by NumPy and from the definitions: nothing here is shared with the kernels.

f_a = sum over Gauss points of  w det A  P dN_a/dX,   P = dW/dF,   A = dX/dr

One-point hexes: G_a = mean of dN_a/dX over the volume V as the only gradient, and for the signs h of every hourglass
mode a stiffness k gamma gamma^t with gamma_a = h_a - (sum over b of h_b X_b).G_a, k = 0.05 (lam + 2 mu) V G:G / 8.
One volume change per hex: without the part of the first modulus k at the points, and for the cell k/2 V e^2 with
e = (sum of w det A det F)/V - 1, for the linear law the mean of tr H.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...base.errors import InputError

CORNERS = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)])
SIGNS = 2.0 * CORNERS - 1.0
HOURGLASS = np.array([np.prod(SIGNS[:, axes], axis=1) for axes in ([0, 1], [0, 2], [1, 2], [0, 1, 2])])
AT_ONCE = 4096  # cells a block


def shape_slopes(kind: str) -> tuple[np.ndarray, np.ndarray]:
    """Return dN/dr [points, corners, 3] on the unit cell and the weights of its Gauss points [points]."""
    if kind == "tet4":
        return np.array([[(-1.0, -1, -1), (1, 0, 0), (0, 1, 0), (0, 0, 1)]]), np.array([1 / 6])
    if kind == "wedge6":  # 3 points (r, s) of the triangle times 2 along t
        flat, slopes = np.array([(-1.0, -1.0), (1.0, 0.0), (0.0, 1.0)]), []
        for t in 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3.0):
            for r, s in ((1 / 6, 1 / 6), (2 / 3, 1 / 6), (1 / 6, 2 / 3)):
                ends = [np.column_stack([share * flat, sign * np.array([1 - r - s, r, s])]) for share, sign in
                        ((1 - t, -1.0), (t, 1.0))]  # fmt: skip
                slopes.append(np.concatenate(ends))
        return np.array(slopes), np.full(6, 1 / 12)
    if not kind.startswith("hex8"):
        raise InputError("--kinds", kind, "has no reference yet: write one in tcontact/lab/bench/reference.py")
    points = 0.5 + (CORNERS - 0.5) / np.sqrt(3.0)
    value = np.where(CORNERS == 1, points[:, None], 1.0 - points[:, None])
    slope = np.broadcast_to(2.0 * CORNERS - 1.0, value.shape)
    axes = [np.prod(np.where(np.arange(3) == axis, slope, value), axis=2) for axis in range(3)]
    return np.stack(axes, axis=2), np.full(8, 1 / 8)


def energy_and_stress(law: str, moduli: Sequence[float], h: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return W [...] [J/m^3] and P = dW/dF [..., 3, 3] [Pa] for displacement gradients h [..., 3, 3]."""
    eye, turned = np.eye(3), np.swapaxes(h, -1, -2)
    f = eye + h
    lam, mu = moduli[:2]
    if law in ("neo-hookean", "mooney-rivlin"):
        c2 = moduli[2] / 4 if law == "mooney-rivlin" else 0.0
        c1 = mu / 2 - 2 * c2
        j, c = np.linalg.det(f), np.swapaxes(f, -1, -2) @ f
        first, square = np.trace(c, axis1=-2, axis2=-1), np.trace(c @ c, axis1=-2, axis2=-1)
        w = c1 * (first - 3) + c2 * ((first**2 - square) / 2 - 3) - mu * np.log(j) + lam / 2 * (j - 1) ** 2
        pull = (lam * (j - 1) * j - mu)[..., None, None] * np.swapaxes(np.linalg.inv(f), -1, -2)
        return w, 2 * c1 * f + 2 * c2 * (first[..., None, None] * f - f @ c) + pull
    if law == "ogden":
        squares, frame = np.linalg.eigh(np.swapaxes(f, -1, -2) @ f)
        j, w, pull = np.linalg.det(f), 0.0, 0.0  # pull: l_i dW/dl_i
        for ratio, alpha in zip(moduli[2::2], moduli[3::2], strict=True):
            power = squares ** (alpha / 2) - 1
            w = w + ratio * (np.sum(power, axis=-1) - alpha * np.log(j))
            pull = pull + ratio * alpha * power
        slope = (pull + (lam * (j - 1) * j)[..., None]) / squares
        return w + lam / 2 * (j - 1) ** 2, f @ (frame * slope[..., None, :]) @ np.swapaxes(frame, -1, -2)
    if law not in ("linear", "st-venant-kirchhoff"):
        raise InputError("--laws", law, "has no reference yet: write one in tcontact/lab/bench/reference.py")
    strain = 0.5 * (h + turned) if law == "linear" else 0.5 * (h + turned + turned @ h)
    trace = np.trace(strain, axis1=-2, axis2=-1)
    stress = lam * trace[..., None, None] * eye + 2 * mu * strain
    w = lam / 2 * trace**2 + mu * np.sum(strain**2, axis=(-1, -2))
    return w, stress if law == "linear" else f @ stress


def volume_change(law: str, h: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return det F - 1 [...] and its slope [..., 3, 3]; for the linear law tr H and I."""
    if law == "linear":
        return np.trace(h, axis1=-2, axis2=-1), np.broadcast_to(np.eye(3), h.shape)
    f = np.eye(3) + h
    j = np.linalg.det(f)
    return j - 1, j[..., None, None] * np.swapaxes(np.linalg.inv(f), -1, -2)


def force(
    kind: str, law: str, moduli: Sequence[float], nodes: np.ndarray, cells: np.ndarray, u: np.ndarray
) -> tuple[np.ndarray, float]:
    """Return dW/du [n, 3] [N] and W [J] of cells [m, corners] at displacements u [n, 3]; moduli: of the law."""
    slopes, weights = shape_slopes(kind)
    result, energy = np.zeros_like(u), 0.0
    for start in range(0, len(cells), AT_ONCE):
        some = cells[start : start + AT_ONCE]
        a = np.einsum("ekc,pkj->epcj", nodes[some], slopes)
        gradients = np.einsum("pkj,epjc->epkc", slopes, np.linalg.inv(a))
        volume = weights * np.linalg.det(a)
        if kind == "hex8-reduced":
            gradients = np.einsum("ep,epkc->ekc", volume, gradients)[:, None]
            volume = volume.sum(axis=1, keepdims=True)
            gradients /= volume[:, :, None, None]
        h = np.einsum("ekc,epkd->epcd", u[some], gradients)
        mean_dilatation = kind == "hex8-mean-dilatation"
        w, p = energy_and_stress(law, [0.0, *moduli[1:]] if mean_dilatation else moduli, h)
        if mean_dilatation:
            change, slope = volume_change(law, h)
            total = volume.sum(axis=1, keepdims=True)
            e = np.sum(volume * change, axis=1, keepdims=True) / total
            w = w + 0.5 * moduli[0] * e**2
            p = p + moduli[0] * e[..., None, None] * slope
        corner = np.einsum("ep,epcd,epkd->ekc", volume, p, gradients, optimize=True)
        energy += float(np.sum(volume * w))
        if kind == "hex8-reduced":
            mean = gradients[:, 0]
            gamma = HOURGLASS - np.einsum("hk,ekc,eac->eha", HOURGLASS, nodes[some], mean, optimize=True)
            stiffness = 0.05 * (moduli[0] + 2 * moduli[1]) * volume[:, 0] * np.sum(mean**2, axis=(1, 2)) / 8
            q = np.einsum("eha,eac->ehc", gamma, u[some])
            corner += np.einsum("e,eha,ehc->eac", stiffness, gamma, q)
            energy += 0.5 * float(np.einsum("e,ehc,ehc->", stiffness, q, q))
        np.add.at(result, some.ravel(), corner.reshape(-1, 3))
    return result, energy


def stiffness(kind: str, lame: Sequence[float], nodes: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Return K [m, 3 corners, 3 corners] [N/m] of linear elastic cells [m, corners] that use all their Gauss points."""
    slopes, weights = shape_slopes(kind)
    lam, mu = lame
    a = np.einsum("ekc,pkj->epcj", nodes[cells], slopes)
    gradients = np.einsum("pkj,epjc->epkc", slopes, np.linalg.inv(a))
    volume = weights * np.linalg.det(a)
    pairs = np.einsum("ep,epkc,epld->ekcld", volume, gradients, gradients, optimize=True)  # int G_kc G_ld dV
    shear = np.einsum("ekclc->ekl", pairs)
    result = lam * pairs + mu * np.swapaxes(pairs, 2, 4)
    result += mu * shear[:, :, None, :, None] * np.eye(3)[:, None, :]
    return result.reshape(len(cells), cells.shape[1] * 3, -1)
