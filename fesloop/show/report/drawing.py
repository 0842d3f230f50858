"""Pictures that come drawn: whether one may stand in a page."""

from __future__ import annotations

from xml.etree import ElementTree

from fesloop.show.report.parts import Drawing

_ELEMENTS = frozenset((
    "svg", "g", "defs", "title", "desc", "path", "rect", "circle", "ellipse", "line", "polyline", "polygon",
    "text", "tspan", "marker", "clipPath", "linearGradient", "stop", "pattern", "use"))
_SPACE = "{http://www.w3.org/2000/svg}"


def checked_svg(drawing: Drawing) -> str:
    """A drawing's `<svg>`, as it is.

    Raises ValueError where it is not one well-formed `<svg>` with a viewBox, or holds what could run or ask
    for something: other elements than shapes and texts, `on...` attributes, addresses outside itself.
    """
    where = f"drawing {drawing.key!r}"
    try:
        root = ElementTree.fromstring(drawing.svg)
    except ElementTree.ParseError as error:
        raise ValueError(f"{where} is not well-formed: {error}") from error
    if _local(root.tag) != "svg" or "viewBox" not in root.attrib:
        raise ValueError(f"{where} is not an <svg> with a viewBox")
    for element in root.iter():
        if _local(element.tag) not in _ELEMENTS:
            raise ValueError(f"{where} holds <{element.tag}>, which a page does not take")
        for name, value in element.attrib.items():
            if _runs(_local(name), value):
                raise ValueError(f"{where} holds {name}={value!r}, which a page does not take")
    return drawing.svg


def _local(name: object) -> str:
    return str(name).removeprefix(_SPACE).removeprefix("{http://www.w3.org/1999/xlink}")


def _runs(name: str, value: str) -> bool:
    """Whether an attribute runs something or leads out of the drawing."""
    if name.lower().startswith("on"):
        return True
    if name == "href":
        return not value.startswith("#")
    return "url(" in value.replace("url(#", "")
