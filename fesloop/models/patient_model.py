"""The model of one patient that controllers load: a file made by identification, one for each patient
and array.

A file is TOML: whose model it is (patient, channels, electrodes, currents), what it predicts (outputs), the
recruitment curve of each channel, the linear dynamics from recruited fractions to outputs, where it was
identified (operating point) and how well it predicts what it was not fitted to. Units are SI but where a name
says otherwise.
"""

from __future__ import annotations

import json
import math
import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NotRequired, Required

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, TypeAdapter, ValidationError

from fesloop.errors import InputError, InputErrors, did_you_mean
from fesloop.forms.faults import faults_of
from fesloop.forms.schema import closed, keys_at, plain
from fesloop.forms.toml import TomlError, tables_of, write_tables
from fesloop.loop.clock import NS_PER_MS, duration_ns
from fesloop.models.linear_model import LinearModel, Recruitment

if TYPE_CHECKING:
    import control

Array = NDArray[np.float64]
FORMAT = "fesloop patient model 1"
LEAST_FIT = 100.0 * (1.0 - math.sqrt(0.5))
"""Percent, 29.3: from here on a prediction explains half of the variance, 1 - (1 - fit / 100)^2; below, what
it leaves out is more than what it explains. Of presets and members of cohorts that were tried, every model
has more in the free run of some output, and 59 and more in the recruitment of every channel; the worst,
member 4 of cohort 1, has less in the free run of two of three outputs."""
FREE_RUN, HALF_SECOND, RECRUITMENT = "free_run", "half_second", "recruitment"
"""Kinds of fit that judge a model: by output on held-out data, and by channel."""
FAR_DEG = 8.0
"""Error in a posture that is reported (chosen: a hand that opens as little cannot be given its object)."""
_BEYOND = "pressing"
"""Posture beyond the object, which no reference asks for: elements need not reach it to hold an object."""
_MOST_NAMED = 3
_DAY = ", day "
"""Separator of a patient's name and its day."""
_HDF5 = b"\x89HDF\r\n\x1a\n"
"""First bytes of an HDF5 file."""
_SHIPPED = Path(__file__).parent / "shipped"
_NESTED = list[list[float]]
_TABLE: Any = closed("PatientModel", {
    "format": Required[str], "patient": Required[str], "source": Required[str],
    "patient_fingerprint": NotRequired[str],
    "outputs": Required[list[str]], "electrodes": Required[list[str]], "arrays": NotRequired[str],
    "current_ma": Required[list[float]],
    "rate": Required[str], "delay_ms": Required[float],
    "recruitment": Required[closed("Curves", {
        "threshold_ma": Required[list[float]], "spread": Required[list[float]],
        "chronaxie_us": Required[float]})],
    "dynamics": Required[closed("Dynamics", {
        "a": Required[_NESTED], "b": Required[_NESTED], "c": Required[_NESTED],
        "offset": Required[list[float]]})],
    "operating": Required[closed("Operating", {
        "drive": Required[list[float]], "outputs": Required[list[float]]})],
    "fit": Required[dict[str, dict[str, Annotated[float, Field(allow_inf_nan=True)]]]],
    "closing": NotRequired[list[int]], "grasping": NotRequired[list[int]],
    "missed_deg": NotRequired[dict[str, dict[str, float]]], "plant": NotRequired[str],
})
_FORM = TypeAdapter(_TABLE)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PatientModel:
    """Model of a patient for controllers.

    Attributes
    ----------
    patient: in words (`fesloop.experiment.files.patients.describe`); empty for a plant without one.
    source: of which recording.
    patient_fingerprint: SHA-256 of what the patient's file said (`patient_fingerprint` there); empty where
        that is not known.
    outputs: names of the m outputs.
    electrodes: of each channel, in words; empty where there is no stimulator.
    arrays: electrode arrays that it was identified with (`fesloop.models.electrode_arrays.arrays_in_words`);
        empty for the usual ones.
    current_ma: (channels,), at which pulse widths were modulated.
    rate: of the samples.
    model: recruitment, dynamics and delay, from the controller's pulses to the instants of capture: what
        lies between (safety, stimulator) is in it, the tracker's age is not.
    operating_drive, operating_outputs: (channels,), (m,): mean of the binary part, around which it holds.
    fit: percent by kind of prediction and output, on held-out data; under `recruitment` that of the
        curves, by channel ("channel 0"); under `sweep` that of what it was fitted to.
    closing, grasping: channels that close the hand, and all but those that move the wrist alone; empty where
        the channels were given.
    missed_deg: angle that the chosen elements leave of each posture, by output; empty where the channels were
        given.
    plant: kind of the hand that it was identified on, such as "myohand"; empty where that is not known.
    """

    patient: str
    source: str
    outputs: tuple[str, ...]
    electrodes: tuple[str, ...]
    current_ma: tuple[float, ...]
    rate: str
    model: LinearModel
    operating_drive: Array
    operating_outputs: Array
    fit: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    patient_fingerprint: str = ""
    arrays: str = ""
    closing: tuple[int, ...] = ()
    grasping: tuple[int, ...] = ()
    missed_deg: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    plant: str = ""

    def __post_init__(self) -> None:
        model, channels = self.model, len(self.current_ma)
        if model.recruitment is None or model.recruitment.muscles != channels or model.inputs != channels:
            raise InputError("current_ma", f"{channels} channels", f"{model.inputs}, as the model has")
        if not all(math.isfinite(each) and each > 0.0 for each in self.current_ma):
            raise InputError("current_ma", ", ".join(f"{each:g}" for each in self.current_ma),
                             "a finite current above 0 for each channel")
        for key in ("closing", "grasping"):
            for channel in getattr(self, key):
                if not 0 <= channel < channels:
                    raise InputError(key, f"channel {channel}", f"0 to {channels - 1}")
        if len(self.outputs) != model.outputs:
            raise InputError("outputs", f"{len(self.outputs)} names", f"{model.outputs}, as the model has")

    @property
    def day(self) -> str:
        """Day of the patient on which it was identified; empty for none in particular."""
        return self.patient.partition(_DAY)[2].partition(",")[0]

    def to_control(self, rate: str | None = None, pade_order: int = 0) -> control.StateSpace:
        """The identified dynamics, from recruited fractions; see `LinearModel.to_control`."""
        return self.model.to_control(rate, pade_order)

    def weaknesses(self) -> list[str]:
        """Quantities of which the model explains less than half the variance, half a sentence each:
        recruitment curves, then free runs, the least explained first; none of a model without a known fit."""
        found = []
        for kind, what in ((RECRUITMENT, "the recruitment curve of"), (FREE_RUN, "the free run of")):
            weak = [(name, fit) for name, fit in self.fit.get(kind, {}).items() if not fit >= LEAST_FIT]
            found += [f"{what} {name} has a fit of {fit:.1f} %, {_explained(fit)} of the variance"
                      for name, fit in sorted(weak, key=lambda row: np.nan_to_num(row[1], nan=-np.inf))]
        return found

    def misses(self) -> list[tuple[float, str, str]]:
        """Postures that the chosen elements miss by more than `FAR_DEG`: deg, output, posture, in order."""
        return [(abs(deg), output, posture) for posture, row in self.missed_deg.items()
                for output, deg in row.items() if abs(deg) > FAR_DEG]

    def missed_in_words(self) -> str:
        """`misses` of postures that a reference asks for, the farthest first; empty without any."""
        far = sorted((each for each in self.misses() if each[2] != _BEYOND), reverse=True)
        named = ", ".join(f"{output} {deg:.0f} deg from the {posture} hand"
                          for deg, output, posture in far[:_MOST_NAMED])
        return named + (f", and {len(far) - _MOST_NAMED} more" if len(far) > _MOST_NAMED else "")

    @property
    def usable(self) -> bool:
        """True if controllers take it by default.

        Not one with a recruitment curve that explains less than half of the variance, nor one that explains
        as much of no output in the free run, or of most outputs neither there nor half a second ahead.
        """
        free, ahead, curves = (self.fit.get(kind, {}) for kind in (FREE_RUN, HALF_SECOND, RECRUITMENT))
        if not all(fit >= LEAST_FIT for fit in curves.values()):
            return False
        explained = [name for name, fit in free.items()
                     if fit >= LEAST_FIT or ahead.get(name, -math.inf) >= LEAST_FIT]
        return not free or (any(fit >= LEAST_FIT for fit in free.values())
                            and 2 * len(explained) >= len(free))

    def table(self) -> dict[str, Any]:
        """Plain tables, as in a file."""
        model = self.model
        return {
            "format": FORMAT, "patient": self.patient,
            **({"patient_fingerprint": self.patient_fingerprint} if self.patient_fingerprint else {}),
            **({"plant": self.plant} if self.plant else {}),
            "source": self.source, "outputs": list(self.outputs),
            "electrodes": list(self.electrodes), **({"arrays": self.arrays} if self.arrays else {}),
            "current_ma": list(self.current_ma), "rate": self.rate,
            "delay_ms": model.delay_ns / NS_PER_MS,
            "recruitment": plain(model.recruitment),
            "dynamics": {name: plain(getattr(model, name)) for name in ("a", "b", "c", "offset")},
            "operating": {"drive": plain(self.operating_drive), "outputs": plain(self.operating_outputs)},
            "fit": {kind: dict(row) for kind, row in self.fit.items()},
            **{key: list(getattr(self, key)) for key in ("closing", "grasping") if getattr(self, key)},
            **({"missed_deg": {posture: dict(row) for posture, row in self.missed_deg.items()}}
               if self.missed_deg else {})}

    def save(self, path: str | Path) -> None:
        """Write the file. Raises InputError where it cannot be written."""
        write_tables(path, self.table())


_REMEDY = ("identify again with more current, other electrodes or a longer experiment; or allow it: "
           "any_fit = true")


def _explained(fit: float) -> str:
    """Share of the variance that a fit in percent explains."""
    share = 1.0 - (1.0 - fit / 100.0) ** 2
    return f"{100.0 * share:.0f} %" if share > 0.0 else "nothing"


def require_usable(path: str, model: PatientModel) -> None:
    """Raise InputError for a model that is not `usable`, naming what it explains too little of."""
    if not model.usable:
        raise InputError(f"{path}: fit", f"the model explains too little: {'; '.join(model.weaknesses())}",
                         f"half of the variance, a fit of {LEAST_FIT:.1f} %, for every recruitment curve and "
                         "for most outputs", _REMEDY)


def shipped_models() -> list[str]:
    """Names of the models that come with the package."""
    return sorted(path.stem for path in _SHIPPED.glob("*.toml"))


def load_patient_model(path: Path) -> PatientModel:
    """The model of a file, or a shipped one by its name; raises InputError for what is no such thing."""
    if str(path) in shipped_models():
        path = _SHIPPED / f"{path}.toml"
    try:
        with path.open("rb") as file:
            recorded = file.read(len(_HDF5)) == _HDF5
        if recorded:
            raise InputError(str(path), "is a recording (HDF5)", "a model file, made by fesloop identify",
                             f"identify it first: fesloop identify {shlex.quote(str(path))} "
                             "--out own_model.toml")
        table = tables_of(path.read_text(encoding="utf-8"))
    except OSError as fault:
        raise InputError(str(path), f"cannot be read: {fault.strerror}",
                         f"a model file, made by fesloop identify, or one of {', '.join(shipped_models())}",
                         did_you_mean(str(path), shipped_models())) from None
    except (UnicodeDecodeError, TomlError) as fault:
        raise InputError(str(path), f"is not TOML: {fault}",
                         "a model file, made by fesloop identify") from None
    if table.get("format") != FORMAT:
        raise InputError(f"{path}: format", f"{table.get('format')!r}", repr(FORMAT), "run fesloop identify")
    try:
        _FORM.validate_json(json.dumps(table))
    except ValidationError as fault:
        faults = faults_of(fault.errors(include_url=False), table, lambda at: keys_at(_TABLE, at, table),
                           tagged=False)
        raise InputErrors(faults).within(str(path)) from None
    return _from_table(table, path)


def _from_table(table: Mapping[str, Any], path: Path) -> PatientModel:
    curves = table["recruitment"]
    try:
        model = LinearModel(
            **table["dynamics"], delay_ns=duration_ns(table["delay_ms"], NS_PER_MS, "delay_ms"),
            recruitment=Recruitment(threshold_ma=tuple(curves["threshold_ma"]),
                                    spread=tuple(curves["spread"]), chronaxie_us=curves["chronaxie_us"]))
        return PatientModel(
            patient=table["patient"], source=table["source"], outputs=tuple(table["outputs"]),
            electrodes=tuple(table["electrodes"]), current_ma=tuple(table["current_ma"]), rate=table["rate"],
            model=model, fit=table["fit"], operating_drive=np.array(table["operating"]["drive"]),
            operating_outputs=np.array(table["operating"]["outputs"]),
            patient_fingerprint=table.get("patient_fingerprint", ""), arrays=table.get("arrays", ""),
            closing=tuple(table.get("closing", ())), grasping=tuple(table.get("grasping", ())),
            missed_deg=table.get("missed_deg", {}), plant=table.get("plant", ""))
    except InputError as fault:
        raise InputError(f"{path}: {fault.where}", fault.found, fault.allowed, fault.remedy) from None


def electrodes_in_words(stimulator: Mapping[str, Any] | None, channels: int) -> tuple[str, ...]:
    """The virtual electrode of each channel, such as "43+44 (0.3, 0.7)", from a stimulator's parameters.

    Without electrodes channel c has element c; without a stimulator there are none.
    """
    if stimulator is None:
        return ()
    given = stimulator.get("electrodes") or [{"elements": [channel]} for channel in range(channels)]
    words = []
    for electrode in given:
        elements, shares = electrode["elements"], list(electrode.get("shares") or ())
        text = "+".join(str(element) for element in elements)
        words.append(text + (f" ({', '.join(f'{share:g}' for share in shares)})" if shares else ""))
    return tuple(words)


def elements_of(word: str) -> tuple[list[int], list[float]]:
    """Elements and shares of a virtual electrode in words; no shares where all have the same.

    Raises InputError for other words.
    """
    elements, _, shares = word.partition(" (")
    try:
        return ([int(each) for each in elements.split("+")],
                [float(each) for each in shares.rstrip(")").split(", ")] if shares else [])
    except ValueError:
        raise InputError("electrodes", f"{word!r}", 'numbers of elements, such as "43" or "43+44 (0.3, 0.7)"',
                         "identify again") from None


def require_same(path: str, model: PatientModel, wanted: Mapping[str, Any]) -> None:
    """Raise InputError naming both where a model is of another patient, other channels or other outputs.

    `wanted` has those of `patient` (a model of one day may be used on another), `patient_fingerprint`,
    `arrays`, `electrodes`, `current_ma` and `outputs` that are known.
    """
    made_for = {"patient": model.patient.partition(_DAY)[0], "arrays": model.arrays,
                "electrodes": model.electrodes, "current_ma": model.current_ma, "outputs": model.outputs}
    now = wanted.get("patient_fingerprint")
    if now and model.patient_fingerprint == now:
        del made_for["patient"]  # the same patient, by whatever path the file is called
    for key, value in made_for.items():
        if key in wanted and wanted[key] != value:
            if key == "arrays":
                raise InputError(f"{path}: arrays", f"the model is of {value or 'the usual arrays'}",
                                 f"{wanted[key] or 'the usual arrays'}, as this experiment has",
                                 "identify with these arrays: docs/howto/own_array.md")
            remedy = {"patient": "identify this one, or say --set any_patient=true",
                      "outputs": "identify with these, or choose those of the model: --set follow=..."}
            if model.grasping:
                remedy["electrodes"] = "take the model's own: --set channels=model"
            raise InputError(f"{path}: {key}", f"the model is of {_words(value)}",
                             f"{_words(wanted[key])}, as this experiment has",
                             remedy.get(key, "identify with these, or change the experiment"))
    if now and model.patient_fingerprint not in ("", now):
        raise InputError(f"{path}: patient_fingerprint",
                         f"the model is of {model.patient!r} as {model.patient_fingerprint[:12]}",
                         f"{now[:12]}: that patient has changed since",
                         "identify again, or say any_patient = true")


def _words(value: Any) -> str:
    if isinstance(value, tuple):
        return "(" + ", ".join(f"{item:g}" if isinstance(item, float) else str(item) for item in value) + ")"
    return repr(value)
