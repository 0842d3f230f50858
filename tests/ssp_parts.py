"""SSP archives made for the tests."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path

_HEAD = (
    '<?xml version="1.0" encoding="UTF-8"?>\n<ssd:SystemStructureDescription name="{name}"'
    ' version="{version}"'
    ' xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription"'
    ' xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon"'
    ' xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues"'
    ' xmlns:ssm="http://ssp-standard.org/SSP1/SystemStructureParameterMapping">\n'
)


def connectors(kinds: Mapping[str, str], units: Mapping[str, str] = {}) -> str:
    """Connectors by name."""
    rows = "".join(f'<ssd:Connector name="{name}" kind="{kind}"><ssc:Real'
                   + (f' unit="{units[name]}"' if name in units else "") + "/></ssd:Connector>"
                   for name, kind in kinds.items())
    return f"<ssd:Connectors>{rows}</ssd:Connectors>"


def binding(values: Mapping[str, float], prefix: str = "", mapping: str = "") -> str:
    """Parameters with their values."""
    rows = "".join(f'<ssv:Parameter name="{name}"><ssv:Real value="{value!r}"/></ssv:Parameter>'
                   for name, value in values.items())
    own = f' prefix="{prefix}"' if prefix else ""
    return (
        f'<ssd:ParameterBindings><ssd:ParameterBinding{own}><ssd:ParameterValues>'
        f'<ssv:ParameterSet version="1.0" name="values"><ssv:Parameters>{rows}</ssv:Parameters>'
        f"</ssv:ParameterSet></ssd:ParameterValues>{mapping}"
        "</ssd:ParameterBinding></ssd:ParameterBindings>"
    )


def component(name: str, kinds: Mapping[str, str], source: str = "resources/lag.fmu", inside: str = "",
              units: Mapping[str, str] = {}) -> str:
    """A component with its connectors."""
    return (f'<ssd:Component name="{name}" type="application/x-fmu-sharedlibrary" source="{source}">'
            f"{connectors(kinds, units)}{inside}</ssd:Component>")


def connection(source: str, target: str, inside: str = "", more: str = "") -> str:
    """A connection between ELEMENT.CONNECTOR, or CONNECTOR of the system itself."""
    text = "<ssd:Connection"
    for side, end in (("start", source), ("end", target)):
        element, _, name = end.rpartition(".")
        text += (f' {side}Element="{element}"' if element else "") + f' {side}Connector="{name}"'
    return f"{text}{more}>{inside}</ssd:Connection>"


def system(name: str, elements: Sequence[str], connections: Sequence[str], before: str = "") -> str:
    """A system; `before` are its connectors and parameters."""
    wires = f"<ssd:Connections>{''.join(connections)}</ssd:Connections>" if connections else ""
    return (f'<ssd:System name="{name}">{before}<ssd:Elements>{"".join(elements)}</ssd:Elements>{wires}'
            "</ssd:System>")


def described(outermost: str, stop_s: float | None = 1.0, version: str = "1.0", name: str = "test") -> str:
    """Text of SystemStructure.ssd."""
    stop = "" if stop_s is None else f'<ssd:DefaultExperiment startTime="0.0" stopTime="{stop_s}"/>'
    return _HEAD.format(name=name, version=version) + outermost + stop + "</ssd:SystemStructureDescription>"


def archived(target: Path, text: str, files: Mapping[str, bytes | Path]) -> Path:
    """An SSP archive."""
    with zipfile.ZipFile(target, "w") as archive:
        archive.writestr("SystemStructure.ssd", text)
        for name, content in files.items():
            archive.writestr(name, content.read_bytes() if isinstance(content, Path) else content)
    return target
