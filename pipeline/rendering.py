"""How this machine can render without a display, found out when the jobs are laid out."""

import ctypes
from dataclasses import replace

from slider.config.schema import Config

_OSMESA = ("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so")


def with_renderer(config: Config) -> Config:
    """Put what works here in the place of ``report.video.renderer=auto``."""
    video = config.report.video
    if video.renderer != "auto":
        return config
    video = replace(video, renderer=find_renderer())
    return replace(config, report=replace(config.report, video=video))


def find_renderer() -> str:
    """``egl`` or ``osmesa``, the first that works, or ``none``; takes a millisecond."""
    if _egl_devices() > 0:
        return "egl"
    return "osmesa" if any(_load(name) for name in _OSMESA) else "none"


def _egl_devices() -> int:
    """Number of devices that EGL offers; MuJoCo renders on one of these."""
    library = _load("libEGL.so.1")
    if library is None:
        return 0
    library.eglGetProcAddress.restype = ctypes.c_void_p
    address = library.eglGetProcAddress(b"eglQueryDevicesEXT")
    if not address:
        return 0
    query = ctypes.CFUNCTYPE(
        ctypes.c_uint, ctypes.c_int, ctypes.c_void_p, ctypes.POINTER(ctypes.c_int)
    )(address)
    count = ctypes.c_int(0)
    return count.value if query(0, None, ctypes.byref(count)) else 0


def _load(name: str) -> ctypes.CDLL | None:
    try:
        return ctypes.CDLL(name)
    except OSError:
        return None
