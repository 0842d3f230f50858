"""What liblsl calls in place of `bind` and `sendto` when it is confined: native code, as its threads call it.

Addresses are those of `struct sockaddr_in` and `sockaddr_in6`: family in the first two bytes in the machine's
order, port in the next two, then the address (IPv4 from byte 4, IPv6 from byte 8).
"""

from __future__ import annotations

import socket
from typing import Any

import numba
import numpy as np
from numba import carray, types  # type: ignore[attr-defined]
from numba.extending import register_jitable

_INET, _INET6 = int(socket.AF_INET), int(socket.AF_INET6)
_INET_SIZE, _INET6_SIZE = 16, 28
_number, _size, _place = types.int32, types.uint32, types.voidptr
_bind: Any = types.ExternalFunction("bind", types.int32(_number, _place, _size))
_getsockname: Any = types.ExternalFunction("getsockname", types.int32(_number, _place, _place))
_sendto: Any = types.ExternalFunction(
    "sendto", types.intp(_number, _place, types.uintp, types.int32, _place, _size))


@register_jitable
def make_loopback(address: Any) -> None:
    """Write the loopback address into a socket address (uint8); what is no internet address stays."""
    family = int(address[0]) + 256 * int(address[1])
    if family == _INET:
        address[4], address[5], address[6], address[7] = 127, 0, 0, 1
    elif family == _INET6:
        address[8:24] = 0
        address[23] = 1


@numba.cfunc(types.int32(_number, _place, _size), cache=True)
def bind_to_loopback(number: int, address: Any, length: int) -> Any:
    """`bind`, to the loopback address whatever is asked for; the port is as asked."""
    asked = carray(address, (length,), np.uint8)
    taken = asked.copy()
    if length >= _INET_SIZE:
        make_loopback(taken)
    return _bind(number, taken.ctypes, length)


@numba.cfunc(types.intp(_number, _place, types.uintp, types.int32, _place, _size), cache=True)
def send_from_loopback(number: int, message: Any, size: int, flags: int, address: Any, length: int) -> Any:
    """`sendto`; a socket without a port is bound to the loopback address first, or it would be to any."""
    own = np.zeros(_INET6_SIZE, np.uint8)
    own_length = np.array([_INET6_SIZE], np.uint32)
    if _getsockname(number, own.ctypes, own_length.ctypes) == 0 and own[2] == 0 and own[3] == 0:
        make_loopback(own)
        _bind(number, own.ctypes, own_length[0])
    return _sendto(number, message, size, flags, address, length)
