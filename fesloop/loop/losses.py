"""Which messages of a wire are lost: one by one, or in bursts."""

from __future__ import annotations

from fesloop.loop.noise import NoiseStream


class Losses:
    """Losses by a two-state Markov chain (Gilbert 1960, doi 10.1002/j.1538-7305.1960.tb03959.x), all lost in
    the bad state and none in the good one, in the long run from the first message on.

        P(lost | the one before was not) = begins = share (1 - stays) / (1 - share)
        P(lost | the one before was too) = stays = 1 - 1 / burst, or share where losses are independent

    With u(k) uniform, message k is lost where u(k) is below both, kept where it is above both, and otherwise
    fares as the chain's rule has it for the fate of message k - 1. Going back to the last message whose u
    alone decides therefore tells of any message without those before: its fate is a function of seed, wire,
    trial and tick, and nothing is to be saved.

    Parameters
    ----------
    share: of the messages, lost in the long run, in [0, 1).
    burst: mean number of messages lost in a row; 0: each is lost or not by itself.
    noise: row k begins with u(k).
    """

    __slots__ = ("_either", "_known", "_never", "_noise", "_same", "_share", "_was_lost")

    def __init__(self, share: float, burst: float, noise: NoiseStream) -> None:
        begins, stays = odds(share, burst)
        self._either, self._never = min(begins, stays), max(begins, stays)
        self._same = stays >= begins
        self._share, self._noise = share, noise
        self._known, self._was_lost = -1, False

    def lost(self, index: int, chance: float) -> bool:
        """Whether the message of tick `index` is lost, whose u is `chance`."""
        decided, u = index, chance
        while decided and decided != self._known and self._either <= u < self._never:
            decided -= 1
            u = float(self._noise.row(decided)[0])
        limit = self._either if decided else self._share
        lost = self._was_lost if decided == self._known else u < limit
        if not self._same and (index - decided) % 2:
            lost = not lost
        self._known, self._was_lost = index, lost
        return lost


def odds(share: float, burst: float) -> tuple[float, float]:
    """Probabilities that a message is lost after one that was not, and after one that was."""
    if not burst:
        return share, share
    stays = 1.0 - 1.0 / burst
    return min(1.0, share * (1.0 - stays) / (1.0 - share)), stays


def least_burst(share: float) -> float:
    """The shortest mean burst that a share of lost messages can come in, but for round-off."""
    return max(1.0, (1.0 - 1e-9) * share / (1.0 - share))
