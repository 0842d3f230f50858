"""Check that MuJoCo can be imported with the OpenGL that the user names."""

from __future__ import annotations

import os

from fesloop.errors import InputError


def require_opengl() -> None:
    """Import MuJoCo, which loads what MUJOCO_GL names.

    Raises InputError if the variable names something that is not installed.
    """
    try:
        import mujoco  # noqa: F401
    except Exception as fault:
        named = os.environ.get("MUJOCO_GL")
        if not named:
            raise
        raise InputError(f"MUJOCO_GL={named}", f"MuJoCo cannot load this OpenGL: {fault}",
                         "egl, osmesa or glfw, as installed", "unset MUJOCO_GL, or install its library "
                         "(Debian: libegl1 for egl, libosmesa6 for osmesa)") from None
