"""What is true of a closed mesh, counted from its triangles alone."""

import numpy as np


def edges(mesh):
    """Directed edges (3 f, 2) of all triangles."""
    return np.concatenate([mesh.faces[:, [0, 1]], mesh.faces[:, [1, 2]], mesh.faces[:, [2, 0]]])


def require_closed(mesh):
    """Each edge once in each direction: no hole, no seam, one side throughout."""
    found = set(map(tuple, edges(mesh).tolist()))
    assert len(found) == 3 * len(mesh.faces)
    assert all((b, a) in found for a, b in found)


def euler_characteristic(mesh):
    """Vertices less edges plus faces; 2 of a ball, 0 of a ring."""
    used = np.unique(mesh.faces)
    assert len(used) == len(mesh.vertices)
    return len(mesh.vertices) - 3 * len(mesh.faces) // 2 + len(mesh.faces)


def volume(mesh):
    """Within, m^3; negative where normals point inwards (divergence theorem)."""
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def winding_numbers(vertices, faces, points):
    """How often a closed surface goes round each point: 1 inside, 0 outside (van Oosterom, Strackee 1983)."""
    a, b, c = (vertices[faces[:, i]][np.newaxis] - points[:, np.newaxis] for i in range(3))
    na, nb, nc = (np.linalg.norm(each, axis=-1) for each in (a, b, c))
    triple = np.einsum("ijk,ijk->ij", a, np.cross(b, c))
    dots = [np.einsum("ijk,ijk->ij", x, y) for x, y in ((a, b), (b, c), (c, a))]
    angle = 2.0 * np.arctan2(triple, na * nb * nc + dots[0] * nc + dots[1] * na + dots[2] * nb)
    return angle.sum(axis=1) / (4.0 * np.pi)
