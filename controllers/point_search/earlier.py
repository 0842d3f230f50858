"""Responses of an earlier search, which a later one of the same person begins with."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar

from fesloop.errors import InputError
from fesloop.forms.schema import plain
from fesloop.hand.movements import movement_text
from fesloop.models.electrode_arrays import USUAL, ArrayLayout


@dataclass(frozen=True, slots=True, kw_only=True)
class EarlierResponse:
    """Response to a query: elements, current, and the quality that the tracker saw."""

    elements: tuple[int, ...]
    current_ma: float
    quality: float

    def __post_init__(self) -> None:
        if not self.elements or min(self.elements) < 0:
            raise InputError("elements", f"{self.elements}", "one or more numbers of elements")
        if not (math.isfinite(self.current_ma) and self.current_ma > 0.0 and math.isfinite(self.quality)):
            raise InputError("current_ma, quality", f"{self.current_ma}, {self.quality}",
                             "a current above 0 and a finite quality")


@dataclass(frozen=True, slots=True, kw_only=True)
class EarlierSearch:
    """Queries of an earlier search and their responses; from a file: the recording of its run.

    Attributes
    ----------
    movement: what was searched for (`fesloop.hand.movements.movement_text`); empty without a search.
    responses: in the order of the queries.
    source: recording that it was read from.
    patient: who was searched, whatever the day, in words (`fesloop.experiment.files.patients.describe`);
        empty without a patient.
    patient_fingerprint: SHA-256 of that patient (`fesloop.experiment.files.patients.patient_fingerprint`);
        empty where that is not known.
    layouts: arrays of which it searched the elements; None: the usual ones.
    """

    FILE_KEYS: ClassVar[Mapping[str, type]] = MappingProxyType({"any_patient": bool})
    OFFERED_BY: ClassVar[str] = ""

    @staticmethod
    def file_tables(path: Path) -> dict[str, Any]:
        """Read the tables from a recording. Raises InputError where it has no point search."""
        from fesloop.experiment.files.patients import identity
        from fesloop.experiment.metrics.search import answered
        from fesloop.experiment.recording.reading import Recording

        with Recording(str(path)) as recording:
            blocks = recording.experiment.get("blocks", {})
            name = next((name for name in sorted(blocks) if blocks[name]["kind"] == "point_search"), "")
            if not name:
                raise InputError(str(path), "has no block of kind point_search", "the recording of a search",
                                 "run `fesloop run array_search_gp`")
            responses = [{"elements": list(each.elements), "current_ma": each.current_ma,
                          "quality": each.quality} for each in answered(recording, name)]
            if not responses:
                raise InputError(str(path), "has no answered query", "a search that answered some")
            layouts = blocks[name]["space"]["layouts"]
            return {"movement": movement_text(blocks[name].get("movement", "")),
                    "responses": responses,
                    "source": f"{recording.name} {recording.fingerprint[:12]}",
                    **identity(recording.experiment.get("patient")),
                    **({"layouts": layouts} if layouts != plain([array.layout for array in USUAL]) else {})}

    movement: str = ""
    responses: tuple[EarlierResponse, ...] = ()
    source: str = ""
    patient: str = ""
    patient_fingerprint: str = ""
    layouts: tuple[ArrayLayout, ...] | None = None
