"""A population of arms under stimulation, and its persons: evoked torque with what is uncertain about it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from importlib.resources import files
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.given_files import read_whole
from fesloop.hand.muscle_paths import JOINTS
from fesloop.models.evoked_torque import (
    Postures,
    Spreads,
    Weights,
    common_shares,
    feature_sizes,
    features,
)

Array = NDArray[np.float64]
FORMAT = "fesloop person 1"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ArmPeople:
    """A population: common part and spread of people's evoked torque.

    Attributes
    ----------
    people: names of those whose recordings it comes from.
    spreads: of weights between people.
    common: by electrode, distribution of the part of its weights that all people share.
    scale_log_mean: (4,), mean logarithm of a repeat's standard deviation, N m, by joint.
    scale_log_sd: its standard deviation between people, common to the joints; scale_log_sd_joint: of each
        joint besides.
    """

    people: tuple[str, ...]
    spreads: Spreads
    common: Mapping[str, Weights]
    scale_log_mean: Array
    scale_log_sd: float
    scale_log_sd_joint: float

    @classmethod
    def shipped(cls) -> Self:
        """The population of five able-bodied people (docs/models/people.md)."""
        return cls.from_document(json.loads((files(__package__) / "arm_population.json").read_text("utf-8")))

    @classmethod
    def from_document(cls, document: Mapping[str, Any]) -> Self:
        """Make a population from what `as_document` makes of it."""
        return cls(
            people=tuple(document["people"]), spreads=_spreads_in(document["spreads"]),
            common=_weights_in(document["common"]), scale_log_mean=np.array(document["scale_log_mean"]),
            scale_log_sd=document["scale_log_sd"], scale_log_sd_joint=document["scale_log_sd_joint"])

    def as_document(self) -> dict[str, Any]:
        """Plain lists and numbers, of six digits; covariances by their lower Cholesky factors."""
        return {"people": list(self.people), "spreads": _short(asdict(self.spreads)),
                "scale_log_mean": _short(self.scale_log_mean), "scale_log_sd": _short(self.scale_log_sd),
                "scale_log_sd_joint": _short(self.scale_log_sd_joint), "common": _weights_of(self.common)}

    def write(self, path: Path) -> None:
        """Write the population as JSON."""
        path.write_text(json.dumps(self.as_document()) + "\n", encoding="utf-8")

    def newcomer(self, electrode: str) -> Weights:
        """Distribution of the weights of a person who was not seen."""
        shares = common_shares(electrode, self.spreads)
        known = self.common.get(electrode) or Weights(np.zeros(len(shares)), np.diag(shares))
        return Weights(known.mean, known.covariance + np.diag(1.0 - shares))

    def stranger(self, rng: np.random.Generator | None = None) -> ArmPerson:
        """A person who was not seen; repeats scatter as a random person's, or as the mean without `rng`."""
        scale = np.exp(self.scale_log_mean) if rng is None else self.scales(1, rng)[0]
        return ArmPerson("", self.spreads, scale, {name: self.newcomer(name) for name in self.common}, ())

    def scales(self, number: int, rng: np.random.Generator) -> Array:
        """Random standard deviations of a repeat (number, 4), N m, of people who were not seen.

        Their logarithms have Student's distribution, as their spread comes from few people.
        """
        people = len(self.people)
        widened = self.scale_log_sd * np.sqrt(1.0 + 1.0 / people) * rng.standard_t(people + 1, number)
        joints = self.scale_log_sd_joint * rng.normal(size=(number, len(JOINTS)))
        return np.asarray(np.exp(self.scale_log_mean + widened[:, np.newaxis] + joints))


@dataclass(frozen=True, slots=True, eq=False)
class ArmPerson:
    """A person's evoked torque by posture, with what is uncertain about it.

    Attributes
    ----------
    name: of the person.
    spreads: of the population that it is part of.
    scale_nm: (4,), standard deviation of a repeat, by joint.
    weights: distribution of each electrode's weights.
    tried: electrodes that this person's own trials had.
    """

    name: str
    spreads: Spreads
    scale_nm: Array
    weights: Mapping[str, Weights]
    tried: tuple[str, ...]

    @classmethod
    def from_document(cls, document: Mapping[str, Any]) -> ArmPerson:
        """Make a person from what `as_document` makes of them."""
        return cls(document["person"], _spreads_in(document["spreads"]), np.array(document["scale_nm"]),
                   _weights_in(document["weights"]), tuple(document["tried"]))

    def as_document(self) -> dict[str, Any]:
        """Plain lists and numbers, of six digits; covariances by their lower Cholesky factors."""
        return {"person": self.name, "spreads": _short(asdict(self.spreads)),
                "scale_nm": _short(self.scale_nm), "tried": list(self.tried),
                "weights": _weights_of(self.weights)}

    def torque(self, electrode: str, angles: Array) -> tuple[Array, Array]:
        """Evoked torque at angles (n, 4), rad: mean (n, 4) and standard deviation (n, 4), N m."""
        rows = features(Postures.of(electrode, angles), self.scale_nm, self.spreads)
        mean, covariance = self.weights[electrode]
        return rows @ mean, np.sqrt(np.einsum("njk,kl,njl->nj", rows, covariance, rows))

    def draws(self, electrode: str, angles: Array, number: int, rng: np.random.Generator) -> Array:
        """Random evoked torque (number, n, 4), N m, at angles (n, 4), rad, of the posterior."""
        rows = features(Postures.of(electrode, angles), self.scale_nm, self.spreads)
        mean, covariance = self.weights[electrode]
        drawn = rng.multivariate_normal(mean, covariance, number, method="cholesky")
        return np.asarray(np.einsum("njk,dk->dnj", rows, drawn))


@dataclass(frozen=True, slots=True, kw_only=True)
class StoredWeights:
    """Distribution of one electrode's weights, as a file has it.

    Attributes
    ----------
    mean: (k,). lower: rows of the lower Cholesky factor of the covariance, one after the other.
    """

    mean: tuple[float, ...]
    lower: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.lower) != len(self.mean) * (len(self.mean) + 1) // 2:
            raise InputError("lower", f"{len(self.lower)} numbers",
                             f"{len(self.mean) * (len(self.mean) + 1) // 2}, with {len(self.mean)} of mean")


@dataclass(frozen=True, slots=True, kw_only=True)
class StoredArm:
    """A person's file, as experiments read it.

    Attributes
    ----------
    person: name. spreads: of the population. scale_nm: standard deviation of a repeat, by joint.
    tried: electrodes of the person's own trials. weights: by electrode.
    """

    FILE_KEYS: ClassVar[Mapping[str, type]] = MappingProxyType({})
    OFFERED_BY: ClassVar[str] = ""

    @staticmethod
    def file_tables(path: Path) -> dict[str, Any]:
        """Read the parameters' tables from a file, unchecked. Raises InputError for another kind of file."""
        allowed = f"JSON of the format {FORMAT!r}"
        content = read_whole(path, allowed)
        try:
            document = json.loads(content)
            if document.pop("format") != FORMAT:
                raise ValueError
        except (ValueError, AttributeError, KeyError, TypeError, RecursionError):
            raise InputError(str(path), "is not a person's file", allowed,
                             "write one by `fesloop identify --stimulation`") from None
        return dict(document)

    person: str = ""
    spreads: Spreads | None = None
    scale_nm: tuple[float, ...] = ()
    tried: tuple[str, ...] = ()
    weights: dict[str, StoredWeights] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not self.weights:
            return
        if self.spreads is None or len(self.scale_nm) != len(JOINTS):
            raise InputError("person", "has weights without spreads or scale_nm",
                             f"spreads, and scale_nm of {', '.join(JOINTS)}")
        for name, each in self.weights.items():
            count = sum(feature_sizes(name, "person.weights"))
            if len(each.mean) != count:
                raise InputError(f"person.weights.{name}", f"{len(each.mean)} numbers", f"{count}")

    def as_person(self) -> ArmPerson | None:
        """The person; None for an empty table."""
        return ArmPerson.from_document(asdict(self)) if self.weights else None


NOBODY = StoredArm()


def _short(values: Any) -> Any:
    """Lists and numbers of six digits."""
    if isinstance(values, dict):
        return {key: _short(value) for key, value in values.items()}
    return [_short(value) for value in values] if np.ndim(values) else float(f"{values:.6g}")


def _spreads_in(document: Mapping[str, Any]) -> Spreads:
    values: dict[str, Any] = {key: tuple(value) if isinstance(value, list) else value
                              for key, value in document.items()}
    return Spreads(**values)


def _weights_of(weights: Mapping[str, Weights]) -> dict[str, Any]:
    return {name: {"mean": _short(mean),
                   "lower": _short(np.linalg.cholesky(covariance)[np.tril_indices(len(mean))])}
            for name, (mean, covariance) in weights.items()}


def _weights_in(document: Mapping[str, Any]) -> dict[str, Weights]:
    found = {}
    for name, each in document.items():
        lower = np.zeros((len(each["mean"]),) * 2)
        lower[np.tril_indices(len(lower))] = each["lower"]
        found[name] = Weights(np.array(each["mean"]), lower @ lower.T)
    return found
