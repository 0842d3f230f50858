"""Holding liblsl to the loopback address.

liblsl has settings for what it sends and for the address of one of its sockets, but binds its data and time
servers, and every socket that waits for an answer, to all addresses of the machine (`bind_port_in_range` in
its `socket_utils.cpp`). So its calls of `bind` and `sendto` are led elsewhere: the dynamic linker keeps, for
each library, a table of the addresses of what it calls from others (System V ABI, "Procedure Linkage Table"),
and two entries of liblsl's are replaced. No other library's calls are touched.
"""

from __future__ import annotations

import ctypes
import mmap
import socket
import sys
from collections.abc import Iterator
from ctypes import c_int64, c_size_t, c_uint8, c_uint16, c_uint32, c_uint64, c_void_p
from typing import Any

import numba
import numpy as np
from numba import carray, types  # type: ignore[attr-defined]
from numba.extending import register_jitable

from fesloop.errors import InputError

_STRINGS, _SYMBOLS, _RELOCATIONS, _RELOCATIONS_SIZE = 5, 6, 7, 8
_CALLS_SIZE, _CALLS = 2, 23
"""Tags of a dynamic section (ELF-64 object file format, "Dynamic table"): DT_STRTAB and so on."""
_READ_WRITE = 0x3


class _LinkMap(ctypes.Structure):
    """The beginning of what a handle of glibc's `dlopen` points to (its link.h)."""

    _fields_ = (("base", c_uint64), ("name", c_void_p), ("dynamic", c_uint64))


class _Entry(ctypes.Structure):
    """Elf64_Dyn."""

    _fields_ = (("tag", c_int64), ("value", c_uint64))


class _Relocation(ctypes.Structure):
    """Elf64_Rela."""

    _fields_ = (("offset", c_uint64), ("info", c_uint64), ("addend", c_int64))


class _Symbol(ctypes.Structure):
    """Elf64_Sym."""

    _fields_ = (("name", c_uint32), ("info", c_uint8), ("other", c_uint8), ("section", c_uint16),
                ("value", c_uint64), ("size", c_uint64))


def confine(library: ctypes.CDLL) -> None:
    """Lead what a library binds and sends to the loopback address, before it has opened a socket.

    Raises InputError where that is not possible: on anything but 64-bit Linux with glibc, or where the
    library does not call both functions.
    """
    where = 'network = "loopback"'
    remedy = 'say network = "lab" if other computers may reach these streams'
    if not sys.platform.startswith("linux") or ctypes.sizeof(c_void_p) != 8 or not _is_glibc():
        raise InputError(where, "liblsl cannot be held to this machine on this platform",
                         "64-bit Linux with glibc", remedy)

    compiled: dict[str, Any] = {"bind": bind_to_loopback, "sendto": send_from_loopback}
    wanted = {name: int(function.address) for name, function in compiled.items()}
    places = {name: place for name, place in _called(library) if name in wanted}
    if places.keys() != wanted.keys():
        raise InputError(where, "this liblsl calls other functions than are known", "liblsl 1.16 to 1.18",
                         remedy)
    for name, place in places.items():
        _write(place, wanted[name])


def _is_glibc() -> bool:
    return hasattr(ctypes.CDLL(None), "gnu_get_libc_version")


def _called(library: ctypes.CDLL) -> Iterator[tuple[str, int]]:
    """(name, address of its entry in the table) of every function that a library calls from others."""
    loaded = _LinkMap.from_address(library._handle)
    tags = _dynamic(loaded.dynamic)

    def address(tag: int) -> int:
        """Of a table: glibc has added the base already, other linkers leave it to the reader."""
        value = tags[tag]
        return value if value >= loaded.base else value + loaded.base

    strings, symbols = address(_STRINGS), address(_SYMBOLS)
    for table, size in ((_CALLS, _CALLS_SIZE), (_RELOCATIONS, _RELOCATIONS_SIZE)):
        if table not in tags:
            continue
        count = tags[size] // ctypes.sizeof(_Relocation)
        for relocation in (_Relocation * count).from_address(address(table)):
            number = relocation.info >> 32
            if number:
                symbol = _Symbol.from_address(symbols + number * ctypes.sizeof(_Symbol))
                yield ctypes.string_at(strings + symbol.name).decode(), loaded.base + relocation.offset


def _dynamic(address: int) -> dict[int, int]:
    tags: dict[int, int] = {}
    while (entry := _Entry.from_address(address)).tag:
        tags[entry.tag] = entry.value
        address += ctypes.sizeof(_Entry)
    return tags


def _write(place: int, value: int) -> None:
    """An address into the table, whose page may be closed to writing."""
    libc: Any = ctypes.CDLL(None, use_errno=True)
    libc.mprotect.argtypes = (c_void_p, c_size_t, ctypes.c_int)
    page = place - place % mmap.PAGESIZE
    if libc.mprotect(page, mmap.PAGESIZE, _READ_WRITE) != 0:
        raise OSError(ctypes.get_errno(), "liblsl's table of calls cannot be written")
    c_uint64.from_address(place).value = value


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
