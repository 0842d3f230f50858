"""pylsl and the liblsl behind it: imported when a stream is opened, held to one network for good."""

from __future__ import annotations

from importlib import import_module
from typing import Any, Literal, get_args

from fesloop.errors import InputError

Network = Literal["loopback", "lab"]
_INSTALL = "pip install 'fesloop[lsl]'"
_LOOPBACK = """[ports]
IPv6 = disable
[multicast]
ResolveScope = machine
ListenAddress = 127.0.0.1
[lab]
KnownPeers = {127.0.0.1}
[log]
level = -3
"""
"""Settings of liblsl: ask this machine alone, each of its ports, and print nothing (losses are statuses).
Several outlets share the one port of discovery, where a datagram to the loopback address reaches a single
one; as a known peer the machine is asked at the port of every outlet."""
_opened: dict[str, Any] = {}
"""pylsl under the network that this process opened it for: liblsl reads its settings once in a process."""


def open_library(network: Network = "loopback") -> Any:
    """The module pylsl, for streams of this machine alone ("loopback") or as liblsl is set up ("lab").

    "lab" leaves everything to liblsl and its settings (the file that LSLAPICFG names, or lsl_api.cfg): by
    default it answers on every address of this machine and searches the local network.

    Raises InputError where pylsl or liblsl is missing, cannot be confined, or was opened for the other
    network by this process.
    """
    if network not in get_args(Network):
        raise InputError("network", f"{network!r}", ", ".join(get_args(Network)))
    if network in _opened:
        return _opened[network]
    if _opened:
        raise InputError("network", f"{network!r}, but this process has opened streams for "
                         f"{next(iter(_opened))!r}", "one network a run")
    pylsl = _imported()
    if network == "loopback":
        from fesloop.streams.live.confinement import confine

        confine(import_module("pylsl.lib").lib)
        try:
            pylsl.set_config_content(_LOOPBACK)
        except (AttributeError, NotImplementedError):
            raise InputError('network = "loopback"', f"liblsl {pylsl.library_version()} takes no settings",
                             "liblsl 1.17.7 or later", _INSTALL) from None
    _opened[network] = pylsl
    return pylsl


def _imported() -> Any:
    """pylsl; it raises RuntimeError where it finds no liblsl, or one for another processor."""
    try:
        return import_module("pylsl")
    except ImportError:
        raise InputError("lsl", "live streams need pylsl, which is not installed", remedy=_INSTALL) from None
    except (RuntimeError, OSError) as fault:
        reason = str(fault).strip().splitlines()[0] if str(fault).strip() else "it cannot be loaded"
        raise InputError("lsl", f"pylsl is installed, but not liblsl for this platform ({reason})",
                         remedy=f"{_INSTALL} on x86-64 Linux brings it; elsewhere install liblsl and name "
                         "it in PYLSL_LIB") from None
