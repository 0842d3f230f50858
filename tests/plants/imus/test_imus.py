"""Every source of error of the hand's sensors against the parameter that states it."""

import math
import pickle

import numpy as np
import pytest
from imu_parts import ideal, names, run, sites
from scipy import stats
from scipy.spatial.transform import Rotation

from fesloop.errors import InputError
from fesloop.hand import quaternion
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import RateClock
from fesloop.loop.signals import NEVER, Sample
from plants.imus.block import HAND_SITES, Imus
from plants.imus.device import TriadErrors
from plants.imus.disturbances import Dipole, Knocks, MagneticField, PulseArtefacts, SoftTissue, Tremor

MANY = 300
TRIADS = {"gyr": "gyroscope", "acc": "accelerometer", "mag": "magnetometer"}
SIZES = {"gyr": 1e-2, "acc": 0.1, "mag": 1e-6}


def spread_is(values, sd, tolerance=4.0):
    """Within `tolerance` standard errors of the sd, and the mean of 0."""
    count = values.size
    assert abs(values.std() / sd - 1.0) < tolerance / math.sqrt(2.0 * count)
    assert abs(values.mean()) < tolerance * sd / math.sqrt(count)


def drawn(seed=1):
    rng = np.random.default_rng(seed)
    orientation = quaternion.normalized(rng.normal(size=(17, 4)))
    return [orientation, *rng.normal(size=(3, 17, 3))]


def test_ideal_sensors_read_what_their_sites_feel_to_the_bit():
    given = drawn()
    samples, reports = run(Imus(preset="ideal"), given, 3)
    assert not reports
    for row in samples["gyr"]:
        np.testing.assert_array_equal(row, given[2])
    for row in samples["acc"]:
        np.testing.assert_array_equal(row, given[3])
    earth = quaternion.rotate(quaternion.conjugate(given[0]), MagneticField().earth)
    np.testing.assert_allclose(samples["mag"][-1], earth, rtol=0.0, atol=1e-18)


def test_each_sensor_reads_its_own_site_in_the_order_that_is_asked_for():
    given = drawn()
    imus = Imus(preset="ideal", sites=("F5d", 1, "F2p"), measures=("gyr", "acc"))
    assert [port.shape for port in imus.outputs] == [(3, 3), (3, 3)]
    samples, _ = run(imus, given, 1)
    rows = [HAND_SITES.index("F5d"), 1, HAND_SITES.index("F2p")]
    np.testing.assert_array_equal(samples["acc"][0], given[3][rows])


@pytest.mark.parametrize("kind", ["gyr", "acc", "mag"])
class TestTriads:
    """One error at a time, the rest ideal, of many sensors at rest."""

    def of(self, kind, ticks=1, given=None, trial=0, rate="100", **errors):
        imus = ideal(MANY, measures=(kind,), magnetic_field=MagneticField(strength_ut=0.0),
                     **{TRIADS[kind]: TriadErrors(**errors)})
        still = sites(MANY, force=(0.0, 0.0, 0.0))
        return run(imus, still if given is None else given, ticks, trial=trial, rate=rate)[0][kind]

    def test_white_noise(self, kind):
        size = SIZES[kind]
        samples = self.of(kind, 40, noise_sd=size)
        spread_is(samples, size)
        assert abs(np.corrcoef(samples[1:].ravel(), samples[:-1].ravel())[0, 1]) < 0.03
        assert stats.kstest(samples[::4].ravel() / size, "norm").pvalue > 1e-3

    def test_constant_bias_is_the_same_in_every_tick_and_trial(self, kind):
        size = SIZES[kind]
        first, second = self.of(kind, 2, bias_sd=size), self.of(kind, 2, trial=1, bias_sd=size)
        spread_is(first[0], size)
        np.testing.assert_array_equal(first[0], first[1])
        np.testing.assert_array_equal(first, second)

    def test_instability_is_stationary_and_forgets_with_its_time(self, kind):
        size = SIZES[kind]
        samples = self.of(kind, 60, instability_sd=size, instability_time_s=0.2)
        for tick in (0, 30, 59):
            spread_is(samples[tick], size)
        together = np.mean(samples[:-20] * samples[20:]) / size**2
        assert together == pytest.approx(math.exp(-0.2 / 0.2), abs=0.04)
        other = self.of(kind, 2, trial=1, instability_sd=size, instability_time_s=0.2)
        assert np.abs(other[0] - samples[0]).min() > 0.0

    @pytest.mark.parametrize("rate", ["50", "200"])
    def test_the_walk_grows_with_the_root_of_time_at_any_rate(self, kind, rate):
        size = SIZES[kind]
        samples = self.of(kind, int(rate) + 1, rate=rate, walk=size)
        assert not samples[0].any()
        spread_is(samples[int(rate) // 4], 0.5 * size)
        spread_is(samples[-1], size)

    def test_resolution_rounds_to_digits(self, kind):
        size = SIZES[kind]
        samples = self.of(kind, 10, noise_sd=size, resolution=0.3 * size)
        digits = samples / (0.3 * size)
        np.testing.assert_allclose(digits, np.round(digits), atol=1e-9)
        assert np.unique(np.round(digits)).size > 5

    def test_range_clips_and_keeps_the_sign(self, kind):
        size = SIZES[kind]
        samples = self.of(kind, 10, noise_sd=size, limit=size)
        free = self.of(kind, 10, noise_sd=size)
        np.testing.assert_array_equal(samples, np.clip(free, -size, size))


def responses(make, count=MANY, kind="acc"):
    """Matrices (count, 3, 3) by which sensors answer unit vectors."""
    columns = []
    for axis in np.eye(3):
        given = sites(count, rate=axis, force=axis)
        columns.append(run(make(), given, 1)[0][kind][0])
    return np.stack(columns, axis=-1)


def test_scale_factors():
    made = responses(lambda: ideal(MANY, accelerometer=TriadErrors(scale_sd=0.02)))
    diagonal = np.einsum("nii->ni", made)
    spread_is(diagonal - 1.0, 0.02)
    np.testing.assert_array_equal(made[:, ~np.eye(3, dtype=bool)], 0.0)


def test_axes_that_are_not_orthogonal_keep_their_sensitivity():
    made = responses(lambda: ideal(MANY, gyroscope=TriadErrors(axes_deg=1.0)), kind="gyr")
    np.testing.assert_allclose(np.linalg.norm(made, axis=-1), 1.0, atol=1e-12)
    spread_is(np.degrees(made[:, ~np.eye(3, dtype=bool)]), 1.0)
    between = made @ made.transpose(0, 2, 1)
    spread_is(np.degrees(between[:, [0, 0, 1], [1, 2, 2]]), math.sqrt(2.0))


def test_triads_are_turned_against_each_other():
    def make():
        return ideal(MANY, accelerometer=TriadErrors(turn_deg=1.0), gyroscope=TriadErrors(turn_deg=2.0))

    turns = [Rotation.from_matrix(responses(make, kind=kind)).as_rotvec(degrees=True)
             for kind in ("acc", "gyr")]
    spread_is(turns[0], 1.0)
    spread_is(turns[1], 2.0)
    assert abs(np.corrcoef(turns[0].ravel(), turns[1].ravel())[0, 1]) < 0.15


def test_mounting_scatter_is_recovered_and_common_to_all_triads():
    def make():
        return ideal(MANY, mounting_sd_deg=6.0)

    mounting = responses(make)
    turns = Rotation.from_matrix(mounting).as_rotvec(degrees=True)
    spread_is(turns, 6.0)
    np.testing.assert_array_equal(mounting, responses(make, kind="gyr"))
    field = quaternion.rotate(quaternion.conjugate(sites(MANY)[0]), MagneticField().earth)
    mag = run(make(), sites(MANY), 1)[0]["mag"][0]
    np.testing.assert_allclose(mag, np.einsum("nij,nj->ni", mounting, field), rtol=0.0, atol=1e-18)


def test_a_triad_is_turned_in_the_case_and_the_case_on_the_segment():
    triad, mounted = {"accelerometer": TriadErrors(turn_deg=8.0, scale_sd=0.1)}, {"mounting_sd_deg": 20.0}
    case, mounting, both = (responses(lambda given=given: ideal(20, **given), count=20)
                            for given in (triad, mounted, triad | mounted))
    np.testing.assert_allclose(both, case @ mounting, atol=1e-12)


def test_mounting_angle_is_uniform_between_its_ends_in_every_direction():
    turns = Rotation.from_matrix(responses(lambda: ideal(MANY, mounting_angle_deg=(5.0, 10.0)))).as_rotvec()
    angles = np.degrees(np.linalg.norm(turns, axis=1))
    assert stats.kstest(angles, stats.uniform(5.0, 5.0).cdf).pvalue > 1e-3
    # Of directions uniform on the sphere each component is uniform.
    direction = turns / np.linalg.norm(turns, axis=1, keepdims=True)
    for axis in range(3):
        assert stats.kstest(direction[:, axis], stats.uniform(-1.0, 2.0).cdf).pvalue > 1e-3


@pytest.mark.slow
def test_hard_and_soft_iron_make_an_ellipsoid_off_the_origin():
    """A sensor turned every way: the field's sphere becomes an ellipsoid, whose axes and centre are found."""
    rng = np.random.default_rng(4)
    every = quaternion.normalized(rng.normal(size=(400, 4)))
    imus = ideal(1, soft_iron=0.05, magnetometer=TriadErrors(bias_sd=5e-6), measures=("mag",))
    mag = run(imus, lambda k, _: sites(1, orientation=every[k]), 400, seed=3)[0]["mag"][:, 0] * 1e6
    x, y, z = mag.T
    design = np.stack([x * x, y * y, z * z, 2 * x * y, 2 * x * z, 2 * y * z, 2 * x, 2 * y, 2 * z], axis=-1)
    a, b, c, d, e, f, g, h, i = np.linalg.lstsq(design, np.ones(400), rcond=None)[0]
    shape = np.array([[a, d, e], [d, b, f], [e, f, c]])
    centre = np.linalg.solve(shape, [-g, -h, -i])
    level = 1.0 + centre @ shape @ centre
    stretch = np.sqrt(level / np.linalg.eigvalsh(shape)) / MagneticField().strength_ut
    state = imus.init(Context("imus", seed=3))
    np.testing.assert_allclose(centre, 1e6 * state.sensors.constants[2, 0], atol=1e-6)
    np.testing.assert_allclose(np.sort(stretch), np.linalg.eigvalsh(state.sensors.matrices[2, 0]), atol=1e-9)
    assert np.abs(stretch - 1.0).max() > 0.01
    np.testing.assert_array_equal(state.sensors.matrices[2, 0], state.sensors.matrices[2, 0].T)


def test_soft_iron_has_the_stated_spread():
    state = ideal(MANY, soft_iron=0.03).init(Context("imus"))
    upper = state.sensors.matrices[2][:, *np.triu_indices(3)] - np.array([1, 0, 0, 1, 0, 1])
    spread_is(upper, 0.03)


@pytest.mark.slow
@pytest.mark.parametrize(("loss", "burst", "length"),
                         [(0.1, 0.0, 1.0 / 0.9), (0.1, 4.0, 4.0), (0.4, 2.0, 2.0)])
def test_share_lost_and_length_of_gaps(loss, burst, length):
    imus = ideal(60, measures=("gyr", "acc"), loss=loss, burst_samples=burst)
    samples, _ = run(imus, sites(60), 2000)
    lost = np.isnan(samples["gyr"][:, :, 0])
    np.testing.assert_array_equal(lost, np.isnan(samples["acc"]).all(axis=-1))
    np.testing.assert_array_equal(lost, np.isnan(samples["acc"]).any(axis=-1))
    assert lost.mean() == pytest.approx(loss, rel=0.05)
    first = np.isnan([run(imus, sites(60), 1, seed=seed)[0]["gyr"][0, :, 0] for seed in range(40)]).mean()
    assert first == pytest.approx(loss, abs=4.0 * math.sqrt(loss / 2400.0))
    starts = (lost[1:] & ~lost[:-1]).sum()
    assert lost[1:].sum() / starts == pytest.approx(length, rel=0.05)
    assert abs(np.corrcoef(lost[:, 0], lost[:, 1])[0, 1]) < 0.15


def test_knocks_have_their_number_size_and_any_direction():
    imus = ideal(60, measures=("gyr", "acc"), knocks=Knocks(per_s=2.0, size=50.0))
    samples, _ = run(imus, sites(60, force=(0.0, 0.0, 0.0)), 2000)
    assert not samples["gyr"].any()
    sizes = np.linalg.norm(samples["acc"], axis=-1)
    struck = sizes > 0.0
    np.testing.assert_allclose(sizes[struck], 50.0)
    # At the first tick no time has passed yet.
    expected = 1999 * 60 * -math.expm1(-0.02)
    assert struck.sum() == pytest.approx(expected, abs=4.0 * math.sqrt(expected))
    directions = samples["acc"][struck] / 50.0
    assert np.abs(directions.mean(axis=0)).max() < 4.0 / math.sqrt(3.0 * len(directions))
    assert np.abs(directions.T @ directions / len(directions) - np.eye(3) / 3.0).max() < 0.05
    again, _ = run(imus, sites(60, force=(0.0, 0.0, 0.0)), 2000, trial=1)
    assert not np.array_equal(samples["acc"], again["acc"])


def test_clipping_is_told_when_it_begins_with_the_names_of_those_that_clip():
    imus = Imus(preset="ideal", sites=("hand", "F2d", "F3d"), gyroscope=TriadErrors(limit=10.0))

    def given(k, _):
        values = sites(17)
        values[2][HAND_SITES.index("F2d"), 1] = -20.0 if 2 <= k < 8 else 0.0
        values[2][HAND_SITES.index("F3d"), 0] = 20.0 if 5 <= k < 6 else 0.0
        return values

    samples, reports = run(imus, given, 10)
    assert reports == [(2, "clipped", "gyr of F2d"), (5, "clipped", "gyr of F3d")]
    assert samples["gyr"][3, 1, 1] == -10.0
    assert samples["gyr"][5, 2, 0] == 10.0


def test_a_gap_in_the_samples_of_a_clipped_sensor_does_not_tell_of_it_anew():
    imus = ideal(4, loss=0.5, gyroscope=TriadErrors(limit=1.0))
    samples, reports = run(imus, sites(4, rate=(5.0, 0.0, 0.0)), 100)
    assert np.isnan(samples["gyr"]).any(axis=(0, 2)).all()
    assert reports == [(0, "clipped", "gyr of s0, s1, s2, s3")]


def test_nothing_is_guessed_before_the_sites_have_come():
    imus = Imus(preset="ideal", measures=("acc",))
    state, tick = imus.init(Context("imus")), Tick()
    blank = [Sample(port.initial_value(), NEVER, NEVER, NEVER) for port in imus.inputs]
    for _ in range(2):
        (acc,) = imus.step(state, blank, tick)
        assert np.isnan(acc).all()
    assert [status for status, _ in tick.reports] == ["waiting"]
    given = [*blank[:3], Sample(sites(17)[3], 0, 0, 0)]
    (acc,) = imus.step(state, given, tick)
    np.testing.assert_array_equal(acc, sites(17)[3])


def test_two_blocks_of_one_device_are_one_device_and_leaving_strips_off_changes_no_sensor():
    given = drawn()
    common = {"device": "glove", "mounting_sd_deg": 5.0, "accelerometer": TriadErrors(bias_sd=0.1)}
    gyr = Imus(preset="ideal", measures=("gyr",), **common)
    rest = Imus(preset="ideal", measures=("acc", "mag"), sites=("F2d", "hand"), **common)
    whole = Imus(preset="ideal", **common)
    alone = run(gyr, given, 1, name="a", seed=5)[0] | run(rest, given, 1, name="b", seed=5)[0]
    every = run(whole, given, 1, name="c", seed=5)[0]
    rows = [HAND_SITES.index("F2d"), HAND_SITES.index("hand")]
    np.testing.assert_array_equal(alone["gyr"], every["gyr"])
    for kind in ("acc", "mag"):
        np.testing.assert_array_equal(alone[kind][0], every[kind][0][rows])
    other = run(Imus(preset="ideal", measures=("gyr",), **common | {"device": "other"}), given, 1, seed=5)[0]
    assert np.abs(other["gyr"] - every["gyr"]).max() > 0.01


def test_a_carried_dipole_goes_with_its_site_and_a_fixed_one_stays():
    position = np.random.default_rng(2).normal(scale=0.1, size=(17, 3))
    dipoles = (Dipole(position=(0.0, 0.0, 0.1), moment=(0.0, 0.0, 1.0), carrier="hand"),)
    carried = MagneticField(strength_ut=0.0, dipoles=dipoles)
    imus = Imus(preset="ideal", measures=("mag",), magnetic_field=carried)
    given = sites(17, position=position)
    moved = sites(17, position=position + np.array([1.0, -2.0, 0.5]))
    here, there = (run(imus, values, 1)[0]["mag"][0] for values in (given, moved))
    np.testing.assert_allclose(here, there, rtol=1e-9)
    room = MagneticField(strength_ut=0.0, dipoles=(
        Dipole(position=tuple(position[1] + [0.0, 0.0, 0.1]), moment=(0.0, 0.0, 1.0)),))
    np.testing.assert_allclose(here, room.in_room(position), rtol=1e-12)
    fixed = Imus(preset="ideal", measures=("mag",), magnetic_field=room)
    np.testing.assert_allclose(run(fixed, moved, 1)[0]["mag"][0], room.in_room(moved[1]), rtol=1e-12)
    assert np.abs(here).max() > 5.0 * np.abs(run(fixed, moved, 1)[0]["mag"][0]).max()


@pytest.mark.slow
def test_with_every_error_a_snapshot_continues_to_the_bit():
    imus = Imus(preset="salchow2019", loss=0.1, burst_samples=3.0, soft_tissue=SoftTissue(), tremor=Tremor(),
                artefacts=PulseArtefacts(), gyroscope=TriadErrors(walk=1e-3), channels=1)
    rng, clock = np.random.default_rng(8), RateClock.from_rate("100")
    feeds = [[Sample(value, 0, 0, 0) for value in drawn(k)]
             + [Sample(rng.uniform(0.0, 1e-3, (1, 2)), 0, 0, clock.tick(k // 2 * 2))] for k in range(60)]

    def steps(state, first, last):
        rows, tick = [], Tick()
        for k in range(first, last):
            tick.index, tick.time_ns = k, clock.tick(k)
            rows.append(imus.step(state, feeds[k], tick))
        return np.array(rows)

    context = Context("imus", seed=2, clock=clock)
    whole = steps(imus.init(context), 0, 60)
    state = imus.init(context)
    steps(state, 0, 23)
    saved = pickle.dumps(state)
    steps(state, 23, 60)
    np.testing.assert_array_equal(steps(pickle.loads(saved), 23, 60), whole[23:])
    assert np.isnan(whole).any()


@pytest.mark.parametrize(("parameters", "name"), [
    ({"measures": ()}, "measures"), ({"measures": ("gyr", "gyr")}, "measures"),
    ({"measures": ("gir",)}, "measures"), ({"preset": "salchow"}, "preset"),
    ({"sites": ("hnad",)}, "did you mean 'hand'"), ({"sites": (17,)}, "sites"),
    ({"sites": ("hand", 1)}, "each site once"), ({"mag_sites": ("F6d",)}, "mag_sites"),
    ({"sites": ("forearm",), "preset": "kortier2014"}, "no sensor has a magnetometer"),
    ({"mounting_sd_deg": -1.0}, "mounting_sd_deg"), ({"mounting_angle_deg": (1.0,)}, "mounting_angle_deg"),
    ({"soft_iron": math.nan}, "soft_iron"), ({"loss": 1.0}, "loss"), ({"loss": -0.1}, "loss"),
    ({"loss": 0.1, "burst_samples": 0.5}, "burst_samples"),
    ({"loss": 0.8, "burst_samples": 2.0}, "burst_samples"),
    ({"magnetic_field": MagneticField(dipoles=(
        Dipole(position=(0, 0, 0), moment=(0, 0, 1), carrier="thumb"),))}, "carrier"),
])
def test_parameters_that_cannot_be_are_named(parameters, name):
    with pytest.raises(InputError, match=name):
        Imus(**parameters)


@pytest.mark.parametrize("wrong", [{"noise_sd": -1.0}, {"instability_time_s": 0.0}, {"limit": -1.0},
                                   {"resolution": math.inf}, {"axes_deg": math.nan}])
def test_errors_of_triads_that_cannot_be_are_named(wrong):
    with pytest.raises(InputError, match=next(iter(wrong))):
        TriadErrors(**wrong)


@pytest.mark.parametrize("wrong", [{"per_s": -1.0}, {"per_s": math.nan}, {"per_s": 1.0, "size": math.inf}])
def test_knocks_that_cannot_be_are_named(wrong):
    with pytest.raises(InputError, match=list(wrong)[-1]):
        Knocks(**wrong)


def test_pulses_of_another_shape_are_refused():
    with pytest.raises(InputError, match=r"pulses: the wired signal has shape \(4,\)"):
        Imus(tremor=Tremor()).resolve({"pulses": (4,)})


def test_sites_have_the_names_of_the_hand():
    assert len(HAND_SITES) == 17
    assert HAND_SITES[:3] == ("forearm", "hand", "F1m")
    assert names(2) == ("s0", "s1")
