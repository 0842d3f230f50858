"""pylsl and the liblsl behind it, imported when a stream is opened and configured once in a process."""

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
"""Settings of liblsl: it searches this machine alone, answers searches of this machine alone, and prints
nothing (losses are statuses). Several outlets share the one port of discovery, where a datagram to the
loopback address reaches a single one; as a known peer the machine is searched at the port of every outlet.
liblsl has no setting for the address that its data and time servers bind: every one of the machine."""
_opened: dict[str, Any] = {}
"""pylsl under the network that this process opened it for: liblsl reads its settings once in a process."""


def open_library(network: Network = "loopback") -> Any:
    """The module pylsl, for streams of this machine ("loopback") or as liblsl is configured ("lab").

    "lab" leaves everything to liblsl and its settings (the file that LSLAPICFG names, or lsl_api.cfg): by
    default it searches the local network and answers its searches.

    Raises InputError where pylsl or liblsl is missing, takes no settings, or was opened for the other network
    by this process.
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
        try:
            pylsl.set_config_content(_LOOPBACK)
        except (AttributeError, NotImplementedError):
            raise InputError('network = "loopback"', f"liblsl {pylsl.library_version()} takes no settings",
                             "liblsl 1.17.7 or later", _INSTALL) from None
    _opened[network] = pylsl
    return pylsl


def _imported() -> Any:
    """The module pylsl, which raises RuntimeError where it finds no liblsl, or one for another processor."""
    try:
        return import_module("pylsl")
    except ImportError:
        raise InputError("lsl", "live streams need pylsl, which is not installed", remedy=_INSTALL) from None
    except (RuntimeError, OSError) as fault:
        reason = str(fault).strip().splitlines()[0] if str(fault).strip() else "it cannot be loaded"
        raise InputError("lsl", f"pylsl is installed, but not liblsl for this platform ({reason})",
                         remedy=f"{_INSTALL} on x86-64 Linux brings it; elsewhere install liblsl and name "
                         "it in PYLSL_LIB") from None
