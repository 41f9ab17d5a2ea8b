"""The forward direction: palms, motions, statics, touchpads, simulation."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import palpate
from palpate import PalmMotion, PalmMove, PalmPair, SupportFunction, Touchpad


def test_contacts_lie_on_both_palms(egg: SupportFunction) -> None:
    palms = PalmPair(0.7, 1.6, base1_m=(0.01, 0.0), base2_m=(-0.01, 0.0))
    psi = 0.4
    s1, s2 = palms.contact_positions_m(egg, psi)
    com = np.array(palms.center_of_mass_m(egg, psi))
    rotation = np.array([[np.cos(psi), -np.sin(psi)], [np.sin(psi), np.cos(psi)]])
    felt = com + egg.boundary(np.array(palms.contact_angles(psi))) @ rotation.T
    assert_allclose(felt, palms.contact_points_m(s1, s2), atol=1e-12)
    assert_allclose(palms.phi12_rad, palms.phi1_rad + palms.phi2_rad)
    f1, f2 = palms.contact_forces_n(0.1)
    normal1, normal2 = (-np.sin(0.7), np.cos(0.7)), (np.sin(2.3), -np.cos(2.3))
    assert_allclose(f1 * np.array(normal1) + f2 * np.array(normal2), (0, 0.1 * 9.80665), atol=1e-12)
    assert repr(PalmPair(0.5, 1.0)) == "PalmPair(phi1_rad=0.5, phi2_rad=1)"


def test_readings_tell_the_curvature(egg: SupportFunction) -> None:
    """Equations 7 and 8 agree, and differences of them give the radii of curvature by equation 9."""
    phi2, h = 1.4, 1e-5

    def felt(t: float) -> tuple[PalmPair, float, tuple[float, float, float, float]]:
        palms, psi = PalmPair(0.6 + 0.2 * t, phi2 + 0.1 * t), 0.3 - 0.5 * t
        return palms, palms.contact_angles(psi)[0], palms.generalized_support_m(*palms.contact_positions_m(egg, psi))

    (_, theta_a, before), (palms, theta1, now), (_, theta_b, after) = felt(-h), felt(0), felt(h)
    assert_allclose(now, egg.generalized_support_m(theta1, phi2), atol=1e-12)
    rate = 1 / (2 * h)
    rates = ((theta_b - theta_a) * rate, 0.1, (after[0] - before[0]) * rate, (after[2] - before[2]) * rate)
    v1, v2 = palpate.radii_of_curvature_m(now, rates, palms.phi2_rad)
    assert v1 == pytest.approx(egg.v(theta1), rel=1e-6)
    assert v2 == pytest.approx(egg.v(palms.contact_angles(0.3)[1]), rel=1e-6)
    assert palpate.radii_of_curvature_m(now, (0, 0, 0, 0), phi2) == (None, None)


def test_an_object_rests_where_its_energy_is_least(egg: SupportFunction) -> None:
    landscape = palpate.EnergyLandscape(egg, PalmPair(0.7, 1.6))
    psi = np.linspace(0, 2 * np.pi, 3601)
    heights = landscape.height_m(psi)
    lowest = min(landscape.stable_poses(), key=lambda pose: pose.height_m)
    assert_allclose(lowest.height_m, heights.min(), atol=1e-8)
    assert_allclose(landscape.height_m(lowest.psi_rad), lowest.height_m)
    assert_allclose(landscape.balance_m(lowest.psi_rad), 0, atol=1e-12)
    assert landscape.balance_slope_m(lowest.psi_rad) > 0
    assert lowest.stiffness_m > 0
    assert_allclose(landscape.descend(lowest.psi_rad + 0.01), lowest.psi_rad, atol=1e-9)
    assert not landscape.is_flat
    assert palpate.EnergyLandscape(SupportFunction(0.03), PalmPair(0.7, 1.6)).is_flat


def test_a_pose_is_followed_through_jumps() -> None:
    square = SupportFunction.named("square")
    start, end = PalmPair(0.2, 0.9), PalmPair(1.9, 0.9)
    jumps = []
    for psi in np.linspace(0, 6, 7):
        rest, on_the_way = palpate.follow(square, start, end, float(psi))
        assert_allclose(palpate.EnergyLandscape(square, end).balance_m(rest), 0, atol=1e-10)
        jumps += on_the_way
    assert jumps
    for jump in jumps:
        assert jump.height_after_m < jump.height_before_m
        assert jump.physical
        assert jump.height_drop_m == jump.height_before_m - jump.height_after_m
        assert_allclose(jump.energy_lost_j(0.1), 0.1 * 9.80665 * jump.height_drop_m)
        assert 0 <= jump.time_s <= 1


def test_motions_go_where_they_are_told() -> None:
    there = [PalmMove.rotate(0.3, 2), PalmMove.open(-0.2, 1), PalmMove.open_one(1, 0.1, 1), PalmMove.wait(0.5)]
    there.append(PalmMove.open_and_rotate(0.1, 0.1, 1))
    motion = PalmMotion.schedule(PalmPair(0.5, 1.2), [PalmMove.back_and_forth(2, there)])
    assert_allclose(motion.duration_s, 4 * 5.5)
    assert_allclose(motion.at(1e9).phi1_rad, 0.5)
    assert_allclose(motion.at(2.0).phi1_rad, 0.8)
    table = motion.sample(10)
    assert table.shape == (221, 7)
    assert_array_equal(table[:, 3:], 0)
    moved = motion.with_bases((0.01, 0), (-0.01, 0))
    assert moved.at(0).base1_m == (0.01, 0.0)
    assert moved.sample(10)[5, 5] == -0.01
    points = np.array([(0, 0.5, 1.0), (1, 0.6, 1.1), (3, 0.5, 1.2)])
    assert_allclose(PalmMotion.through(points).at(1.0).phi2_rad, 1.1)
    assert PalmMotion.random(3, 20) == PalmMotion.random(3, 20) != PalmMotion.random(4, 20)
    assert PalmMotion.squeeze_and_rotate(30).duration_s == pytest.approx(30)
    assert repr(there[0]) == "PalmMove.rotate(0.3, 2)"


def test_a_planned_motion_turns_the_object_without_a_jump(
    egg: SupportFunction, plan: palpate.PlannedMotion, simulation: palpate.Simulation
) -> None:
    assert plan.full_turn
    assert plan.coverage > 0.99
    assert simulation.jumps == []
    assert simulation.coverage > 0.99
    assert abs(simulation.truth.psi_rad[-1] - simulation.truth.psi_rad[0]) > 2 * np.pi
    limits = palpate.PalmLimits(smallest_phi1_rad=0.3, palm_length_m=0.2)
    assert limits.smallest_phi1_rad == 0.3
    narrow = palpate.plan_turn(egg, 40.0, limits=limits)
    assert narrow.motion.sample(10)[:, 1].min() >= 0.3 - 1e-9
    other = palpate.plan_jump_free(egg, 2, 40.0)
    assert palpate.simulate(egg, other, rate_hz=5).jumps == []


def test_the_ways_to_give_a_motion_agree(egg: SupportFunction, plan: palpate.PlannedMotion) -> None:
    reference = palpate.simulate(egg, plan, rate_hz=5)
    start = plan.start_psi_rad
    table = plan.motion.sample(5)
    for motion in (plan.motion, table, table[:, :3], table.tolist()):
        assert palpate.simulate(egg, motion, rate_hz=5, start_psi_rad=start) == reference


def test_a_simulated_log_is_what_the_palms_would_feel(egg: SupportFunction, plan: palpate.PlannedMotion) -> None:
    log, truth = palpate.simulate(egg, plan, rate_hz=5, with_forces=True, mass_kg=0.2)
    assert log.force1_n is not None
    for i in range(0, len(log), 20):
        palms = PalmPair(log.phi1_rad[i], log.phi2_rad[i])
        assert_allclose(palms.contact_positions_m(egg, truth.psi_rad[i]), (log.s1_m[i], log.s2_m[i]), atol=1e-12)
        assert_allclose(palms.contact_forces_n(0.2)[0], log.force1_n[i])
    assert_allclose(truth.shape.harmonics_m[:3], egg.harmonics_m, atol=1e-12)


def test_touchpads_have_their_faults(egg: SupportFunction, plan: palpate.PlannedMotion) -> None:
    pad = Touchpad.interlink(length_m=1.0, noise_sd_m=1e-4, dropout=0.2)
    assert pad.counts_per_inch == 200
    assert_allclose(pad.position_sd_m, np.hypot(1e-4, pad.resolution_m / np.sqrt(12)))
    assert pad.changed(dropout=0.0) == Touchpad.interlink(length_m=1.0, noise_sd_m=1e-4)
    log, _ = palpate.simulate(egg, plan, touchpad=pad, rate_hz=20, with_stated_noise=True)
    seen = ~np.isnan(log.s1_m)
    assert 0.7 < seen.mean() < 0.9
    counts = log.s1_m[seen] / pad.resolution_m
    assert_allclose(counts, np.round(counts), atol=1e-6)
    assert log.s1_sd_m is not None
    assert_allclose(log.s1_sd_m[0], pad.position_sd_m)
    assert Touchpad().read([0.01, 0.03], [1.0, 3.0]) == pytest.approx((0.025, 4.0))
    assert Touchpad().read([], []) is None
    assert len(palpate.simulate(egg, plan, touchpad=Touchpad(rate_hz=2)).log) == 81


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda egg: palpate.simulate(egg, PalmMotion.random(1, 5), touchpad=Touchpad(length_m=0.01)), "runs off palm"),
        (lambda egg: palpate.simulate(egg, np.zeros((0, 3))), "the palm motion has no samples"),
        (lambda egg: palpate.simulate(egg, [(0, 1e300, 1)]), "within two turns"),
        (lambda egg: palpate.simulate(egg, np.zeros((5, 4))), "motion must have 3 or 7 columns, not 4"),
        (lambda egg: palpate.simulate(egg, [(0, 1, np.nan)]), "faulty at its sample 0"),
        (lambda egg: palpate.simulate(SupportFunction(0.03, [(0, 0), (0.02, 0)]), [(0, 1, 1)]), "not a convex object"),
        (lambda egg: palpate.simulate(egg, [(0, 1, 1)], mass_kg=-1), r"mass \(kg\), must be positive"),
        (lambda egg: palpate.simulate(egg, [(0, 1, 1)], touchpad=Touchpad(dropout=2)), "drop-out probability"),
        (lambda egg: palpate.simulate(egg, PalmMotion.random(1, 5), rate_hz=1e9), "more than 5 million"),
        (lambda egg: palpate.plan_turn(egg, -1), "the duration is out of range"),
        (lambda egg: PalmMotion.random(1, 5, amplitude=3), "the amplitude of a random motion must be 0 to 1"),
        (lambda egg: PalmMotion.schedule(PalmPair(0.5, 1), [PalmMove.open(-2, 1)]), "parallel or crossed"),
        (lambda egg: PalmMotion.squeeze_and_rotate(60, times=10**9), "at most a million"),
        (lambda egg: PalmMotion.through([(0, 1, 1)]), "at least two"),
        (lambda egg: PalmMotion.random(1, 5).at(np.nan), "time_s must be a number"),
        (lambda egg: PalmMove.open_one(3, 1, 1), "palm must be 1 or 2, not 3"),  # type: ignore[arg-type]
        (lambda egg: PalmPair(np.nan, 1), "must be finite"),
        (lambda egg: palpate.EnergyLandscape(egg, PalmPair(1, 0)), "parallel or crossed"),
        (lambda egg: palpate.follow(egg, PalmPair(1, 1), PalmPair(1, 4), 0), "parallel or crossed"),
        (lambda egg: Touchpad().read([1], [1, 2]), "differ in length"),
    ],
)
def test_the_impossible_is_refused(egg: SupportFunction, call: object, words: str) -> None:
    assert callable(call)
    with pytest.raises(palpate.InputError, match=words):
        call(egg)


def test_moves_cannot_be_nested_without_end() -> None:
    def nested(times: int) -> PalmMove:
        return PalmMove.back_and_forth(1, [nested(times - 1)]) if times else PalmMove.wait(1)

    assert PalmMotion.schedule(PalmPair(0.5, 1), [nested(5)]).duration_s == 2**5
    assert nested(31) == nested(31)
    with pytest.raises(palpate.MotionError, match="32 deep"):
        nested(32)
