"""Moving hands and their objects, rendered by MuJoCo without a display."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib import import_module
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.show.picture.hand_mesh import Mesh
from fesloop.show.report.parts import Solid
from fesloop.show.report.recorded_hand import ESTIMATE, TRUTH

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]
Colour = tuple[float, float, float]
SKIN: Colour = (0.93, 0.76, 0.66)
GHOST: Colour = (0.90, 0.36, 0.02)
"""Colours of the true hand and of the estimate."""
_OBJECT, _TABLE = (0.36, 0.60, 0.80), (0.80, 0.79, 0.76)
PAPER: Colour = (0.98, 0.98, 0.975)
"""Colour of the background."""
_AHEAD_COVER, _BEHIND_COVER, _EDGE_COVER, _OUTLINE_PX = 0.55, 0.10, 0.85, 2
"""Opacity of the estimate where it is seen and where something hides it, and of its outline; width of that,
pixels (chosen: the true hand stays legible)."""
_BEHIND_M = 0.004
"""The estimate is taken to be so much farther where it is decided which hand is in front, m."""
_FOVY_DEG = 24.0
"""Angle of view, upright (chosen: near a parallel projection, yet what is near is larger)."""
_LIT_LEAST = 0.55
"""Least brightness of the estimate, as a share of its colour."""
_SOLIDS = "solids"
_TRUTH_GROUP, _ESTIMATE_GROUP, _THING_GROUP = 1, 2, 3
_BACKENDS = ("egl", "osmesa", "glfw")
_GEOMS = {"cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER, "sphere": mujoco.mjtGeom.mjGEOM_SPHERE,
          "box": mujoco.mjtGeom.mjGEOM_BOX}


class Stage:
    """Scene of hands and solids, whose poses are set for each picture.

    Parameters
    ----------
    shapes: by hand ("truth", "estimate"), one mesh per segment, in the segment's frame, m.
    solids: object and table.
    width, height: of a picture, pixels.
    """

    def __init__(self, shapes: Mapping[str, Sequence[Mesh]], solids: Sequence[Solid],
                 width: int, height: int) -> None:
        self._alone = TRUTH not in shapes
        self._bodies: dict[str, list[int]] = {}
        spec, names = self._described(shapes, solids, width, height)
        self._model = spec.compile()
        self._data = mujoco.MjData(self._model)
        for hand, each in names.items():
            bodies = [mujoco.mj_name2id(self._model, mujoco.mjtObj.mjOBJ_BODY, name) for name in each]
            self._bodies[hand] = bodies
        self._colours = self._model.geom_rgba.copy()
        self._scene = mujoco.MjvScene(self._model, maxgeom=200)
        self._context = mujoco.MjrContext(self._model, mujoco.mjtFontScale.mjFONTSCALE_100)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        self._area = mujoco.MjrRect(0, 0, width, height)
        self._camera, self._along = mujoco.MjvCamera(), np.zeros(3)
        self._gloss = self._model.mat_specular.copy()
        self._aspect = width / height

    def _described(self, shapes: Mapping[str, Sequence[Mesh]], solids: Sequence[Solid], width: int,
                   height: int) -> tuple[Any, dict[str, list[str]]]:
        """Description of the scene, and names of its bodies: of each hand by segment, and of the solids."""
        spec = mujoco.MjSpec()
        _lights(spec, width, height)
        names: dict[str, list[str]] = {}
        for hand, meshes in shapes.items():
            group = _ESTIMATE_GROUP if hand == ESTIMATE else _TRUTH_GROUP
            names[hand] = [f"{hand} {i}" for i in range(len(meshes))]
            for name, mesh in zip(names[hand], meshes, strict=True):
                body = spec.worldbody.add_body(name=name, mocap=True)
                if len(mesh.faces):
                    _add_mesh(spec, name, mesh)
                    body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, group=group,
                                  rgba=[*(GHOST if hand == ESTIMATE else SKIN), 1.0],
                                  material="ghost" if hand == ESTIMATE else "skin", **_NO_PHYSICS)
        names[_SOLIDS] = [f"solid {i}" for i in range(len(solids))]
        for name, solid in zip(names[_SOLIDS], solids, strict=True):
            body = spec.worldbody.add_body(name=name, mocap=True)
            x, y, z = solid.half_sizes
            size = {"cylinder": [x, z, 0.0], "sphere": [x, 0.0, 0.0], "box": [x, y, z]}[solid.kind]
            table = solid.role == "surface"
            body.add_geom(type=_GEOMS[solid.kind], size=size, rgba=[*(_TABLE if table else _OBJECT), 1.0],
                          material="table" if table else "object", group=_THING_GROUP, **_NO_PHYSICS)
        return spec, names

    def look(self, along: Sequence[float], middle: Array, width_m: float, height_m: float) -> None:
        """Place the camera.

        Parameters
        ----------
        along: (3,), direction of view, into the scene, not vertical.
        middle: (3,), point in the middle of the picture, m.
        width_m, height_m: extent at this point that the picture holds.
        """
        self._along = np.asarray(along) / np.linalg.norm(along)
        east, north, up = self._along
        self._camera.azimuth = float(np.rad2deg(np.arctan2(north, east)))
        self._camera.elevation = float(np.rad2deg(np.arcsin(up)))
        self._camera.lookat[:] = middle
        # The lamp stands above the camera's left shoulder, so that no view is dark.
        right = np.cross(self._along, [0.0, 0.0, 1.0])
        right /= np.linalg.norm(right)
        lit = 0.6 * self._along + 0.35 * right - 0.75 * np.cross(right, self._along)
        self._model.light_dir[0] = lit / np.linalg.norm(lit)
        self._model.light_pos[0] = middle - self._model.light_dir[0]
        half = 0.5 * max(height_m, width_m / self._aspect)
        self._camera.distance = half / np.tan(np.deg2rad(0.5 * _FOVY_DEG))

    def picture(self, hands: Mapping[str, Array], solids: Array) -> Picture:
        """Picture (height, width, 3).

        Parameters
        ----------
        hands: by hand, poses (segments, 7): orientation (w, x, y, z) and position, m.
        solids: (solids, 7), likewise. What is not finite is not shown.
        """
        self._model.geom_rgba[:] = self._colours
        for name, bodies in self._bodies.items():
            rows = solids if name == _SOLIDS else hands.get(name, np.full((len(bodies), 7), np.nan))
            for body, row in zip(bodies, rows, strict=True):
                self._place(body, row)
        seen = [_THING_GROUP, _ESTIMATE_GROUP if self._alone else _TRUTH_GROUP]
        picture = self._rendered(seen, before_paper=True)
        estimate = hands.get(ESTIMATE)
        if self._alone or estimate is None or not np.isfinite(estimate).all():
            return picture
        whole = self._rendered([_ESTIMATE_GROUP])
        # Where both hands coincide the true one is in front.
        self._data.mocap_pos[self._model.body_mocapid[self._bodies[ESTIMATE]]] += _BEHIND_M * self._along
        lit = ~np.isin(self._model.geom_group, [_ESTIMATE_GROUP])
        self._model.geom_rgba[lit, :3] = 0.0
        return _overlaid(picture, whole, self._rendered([*seen, _ESTIMATE_GROUP]))

    def _place(self, body: int, row: Array) -> None:
        if np.isfinite(row).all():
            mocap = self._model.body_mocapid[body]
            self._data.mocap_quat[mocap] = row[:4]
            self._data.mocap_pos[mocap] = row[4:]
        else:
            first, count = self._model.body_geomadr[body], self._model.body_geomnum[body]
            self._model.geom_rgba[first:first + count, 3] = 0.0

    def _rendered(self, groups: Sequence[int], *, before_paper: bool = False) -> Picture:
        """Picture of some groups of bodies before paper, or, without shadows and gloss, before black."""
        option = mujoco.MjvOption()
        option.geomgroup[:] = [each in groups for each in range(len(option.geomgroup))]
        for flag in (mujoco.mjtRndFlag.mjRND_SKYBOX, mujoco.mjtRndFlag.mjRND_SHADOW):
            self._scene.flags[flag] = before_paper
        self._model.mat_specular[:] = self._gloss if before_paper else 0.0
        mujoco.mj_forward(self._model, self._data)
        mujoco.mjv_updateScene(self._model, self._data, option, None, self._camera,
                               mujoco.mjtCatBit.mjCAT_ALL, self._scene)
        mujoco.mjr_render(self._area, self._scene, self._context)
        picture = np.empty((self._area.height, self._area.width, 3), dtype=np.uint8)
        mujoco.mjr_readPixels(picture, None, self._area, self._context)
        return picture[::-1]

    def close(self) -> None:
        """Free the renderer's buffers."""
        self._context.free()


_NO_PHYSICS: dict[str, Any] = {"contype": 0, "conaffinity": 0, "mass": 0.0}


def _add_mesh(spec: Any, name: str, mesh: Mesh) -> None:
    spec.add_mesh(name=name, uservert=mesh.vertices.ravel().tolist(), userface=mesh.faces.ravel().tolist(),
                  inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL, smoothnormal=True)


def _lights(spec: Any, width: int, height: int) -> None:
    """Materials, lights and sizes of buffers."""
    spec.visual.global_.offwidth, spec.visual.global_.offheight = width, height
    spec.visual.global_.fovy = _FOVY_DEG
    spec.visual.quality.offsamples, spec.visual.quality.shadowsize = 8, 4096
    spec.visual.headlight.ambient[:] = [0.32] * 3
    spec.visual.headlight.diffuse[:] = [0.24] * 3
    spec.visual.headlight.specular[:] = [0.0] * 3
    spec.visual.map.znear, spec.visual.map.zfar = 0.02, 20.0
    spec.stat.extent, spec.stat.center = 0.5, [0.0, 0.0, 0.0]
    spec.add_texture(name="paper", type=mujoco.mjtTexture.mjTEXTURE_SKYBOX, width=8, height=48, rgb1=PAPER,
                     builtin=mujoco.mjtBuiltin.mjBUILTIN_FLAT, rgb2=PAPER)
    spec.add_material(name="skin", specular=0.12, shininess=0.25)
    spec.add_material(name="ghost", specular=0.0, emission=0.5)
    spec.add_material(name="object", specular=0.3, shininess=0.5)
    spec.add_material(name="table", specular=0.0)
    spec.worldbody.add_light(name="lamp", type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL, castshadow=True,
                             diffuse=[0.48] * 3, specular=[0.3] * 3, ambient=[0.0] * 3)


def _overlaid(picture: Picture, whole: Picture, ahead: Picture) -> Picture:
    """Picture with a translucent hand over it, and its outline.

    Parameters
    ----------
    whole, ahead: that hand before black, all of it, and the part that nothing in the picture hides.
    """
    light = whole.astype(np.float32) / 255.0
    cover, visible = (np.clip(each[..., 0] / np.float32(255.0 * _LIT_LEAST * GHOST[0]), 0.0, 1.0)
                      for each in (whole, ahead))
    inner = cover
    for axis in (0, 1):
        for by in (-_OUTLINE_PX, _OUTLINE_PX):
            inner = np.minimum(inner, np.roll(cover, by, axis))
    edge = cover - inner
    fill = np.where(visible > 0.0, _AHEAD_COVER * visible, _BEHIND_COVER * cover)
    alpha = np.maximum(fill * inner, _EDGE_COVER * edge)[..., np.newaxis]
    shaded = light / np.maximum(cover, 1e-3)[..., np.newaxis]
    colour = np.where(edge[..., np.newaxis] > 0.3, np.array(GHOST, dtype=np.float32), np.minimum(shaded, 1.0))
    return np.asarray(np.rint((1.0 - alpha) * picture + 255.0 * alpha * colour), dtype=np.uint8)


@contextmanager
def drawing_surface(width: int, height: int) -> Iterator[None]:
    """Context in which OpenGL draws into memory: by EGL, else OSMesa, else a window system.

    The variable MUJOCO_GL, if it is set, names the one that is taken.

    Raises InputError if there is none.
    """
    named = os.environ.get("MUJOCO_GL", "").lower()
    faults = []
    for name in (named,) if named in _BACKENDS else _BACKENDS:
        try:
            context = import_module(f"mujoco.{name}").GLContext(width, height)
            context.make_current()
        except Exception as fault:  # noqa: BLE001 - what fails depends on what the machine lacks
            faults.append(f"{name}: {' '.join(str(fault).split()) or type(fault).__name__}")
            continue
        try:
            yield
        finally:
            context.free()
        return
    raise InputError("film", f"nothing draws in three dimensions here ({'; '.join(faults)})",
                     "OpenGL by EGL or OSMesa", "install libegl1 and libgl1-mesa-dri, or libosmesa6; "
                     "fesloop picture needs neither")
