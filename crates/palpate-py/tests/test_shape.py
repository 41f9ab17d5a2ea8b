"""Support functions."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import palpate
from palpate import SupportFunction


def test_a_circle_is_what_it_should_be() -> None:
    circle = SupportFunction(0.02)
    assert circle.r(1.0) == circle.v(1.0) == 0.02
    assert circle.d(1.0) == 0.0
    assert_allclose(circle.perimeter_m, 2 * np.pi * 0.02)
    assert_allclose(circle.area_m2, np.pi * 0.02**2)
    assert circle.is_convex
    assert_allclose(circle.centroid_m, (0, 0), atol=1e-12)


def test_numbers_give_numbers_and_arrays_give_arrays_of_their_shape(egg: SupportFunction) -> None:
    theta = np.linspace(0, 1, 6).reshape(2, 3)
    assert isinstance(egg.r(0.5), float)
    assert egg.r(theta).shape == egg.d(theta).shape == egg.v(theta).shape == (2, 3)
    assert egg.r([0, 1])[0] == egg.r(0.0)
    assert_allclose(egg.v(theta)[1, 2], egg.v(float(theta[1, 2])))


def test_the_boundary_has_its_perimeter_and_area(egg: SupportFunction) -> None:
    points = egg.boundary(np.linspace(0, 2 * np.pi, 20000))
    steps = np.diff(points, axis=0)
    assert_allclose(np.hypot(*steps.T).sum(), egg.perimeter_m, rtol=1e-6)
    x, y = points[:-1].T
    assert_allclose(0.5 * np.sum(x * steps[:, 1] - y * steps[:, 0]), egg.area_m2, rtol=1e-6)


def test_derivatives_are_those_of_r(egg: SupportFunction) -> None:
    theta, h = np.linspace(0, 6, 50), 1e-4
    assert_allclose(egg.d(theta), -(egg.r(theta + h) - egg.r(theta - h)) / (2 * h), atol=1e-9)
    curvature = egg.r(theta) + (egg.r(theta + h) - 2 * egg.r(theta) + egg.r(theta - h)) / h**2
    assert_allclose(egg.v(theta), curvature, atol=1e-7)


def test_a_shape_is_made_again_from_its_numbers(egg: SupportFunction) -> None:
    assert SupportFunction(egg.mean_radius_m, egg.harmonics_m) == egg
    theta = np.linspace(0, 6, 40)
    assert_allclose(SupportFunction.from_samples(theta, egg.r(theta), 3).harmonics_m, egg.harmonics_m, atol=1e-12)


def test_a_polygon_is_rounded() -> None:
    side = 0.02
    square = [(-side, -side), (side, -side), (side, side), (-side, side)]
    shape = SupportFunction.from_polygon(square, order=40)
    assert shape.is_convex
    assert 4 * side**2 < shape.area_m2 < 1.1 * 4 * side**2
    assert_allclose(shape.centroid_m, (0, 0), atol=1e-9)
    off = SupportFunction.from_polygon(np.array(square), order=40, center_of_mass_m=(0.005, 0))
    assert_allclose(off.centroid_m, (-0.005, 0), atol=1e-4)


def test_shapes_can_be_moved_turned_and_scaled(egg: SupportFunction) -> None:
    assert_allclose(egg.rotated(0.3).r(1.3), egg.r(1.0))
    assert_allclose(egg.translated(0.001, 0).centroid_m, (0.001, 0), atol=1e-9)
    assert_allclose(egg.scaled(0.06).area_m2, 4 * egg.area_m2)
    random = SupportFunction.random(7)
    assert random == SupportFunction.random(7) != SupportFunction.random(8)
    assert random.is_convex
    for made in (SupportFunction.ellipse(0.03, 0.02), SupportFunction.rounded_polygon(5, mean_radius_m=0.03)):
        assert made.is_convex
    bumpy = SupportFunction(0.03, [(0, 0), (0.02, 0)])
    assert not bumpy.is_convex
    assert bumpy.damped_to_convex().is_convex


def test_arrays_are_read_only_and_shared(egg: SupportFunction, result: palpate.Result) -> None:
    assert result.r is result.r
    for array in (result.r, result.com, result.touches, egg.harmonics_m):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1


def test_a_notebook_shows_the_outline(egg: SupportFunction) -> None:
    svg = egg._repr_svg_()
    assert svg.startswith("<svg")
    assert svg.endswith("</svg>")
    assert "20 mm" in svg
    assert repr(egg).startswith("<SupportFunction: mean radius 30.00 mm, 3 harmonics")


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: SupportFunction.named("cube"), 'no shape is named "cube"; known are circle, disc'),
        (lambda: SupportFunction.named("egg", -1), "the mean radius must be positive and finite"),
        (lambda: SupportFunction(0.03, [(0, 0), (np.nan, 0)]), "harmonic 2 is not finite"),
        (lambda: SupportFunction(np.inf), "the mean radius must be positive and finite"),
        (lambda: SupportFunction.from_polygon([(0, 0), (1, 1)]), "2 points are too few"),
        (lambda: SupportFunction.from_polygon([(0, 0), (1, 1), (2, 2)]), "the points do not determine a shape"),
        (lambda: SupportFunction.from_samples([0, 1], [1, 1], 600), "at most 512"),
        (lambda: SupportFunction.rounded_polygon(1), "the number of corners"),
        (lambda: SupportFunction.random(1, order=0), "the order"),
    ],
)
def test_impossible_shapes_are_refused(make: object, words: str) -> None:
    assert callable(make)
    with pytest.raises(palpate.ShapeError, match=words):
        make()


SOAP_M = [(0.0, 0.0), (0.06, 0.0), (0.06, 0.04), (0.0, 0.04)]


def test_an_outline_says_what_its_fit_costs(tmp_path: Path) -> None:
    fit = SupportFunction.from_outline(SOAP_M)
    assert len(fit.shape.harmonics_m) == 256
    assert 0 < fit.cut_m < fit.bulge_m == fit.residual_m < 3e-4
    assert fit.dent_m == 0
    # The middle of a flat side is where the shape bulges most.
    assert_allclose(fit.shape.r(np.pi / 2), 0.02 + fit.bulge_m, atol=1e-6)
    assert fit.residual_m < (SupportFunction.from_polygon(SOAP_M).r(np.pi / 2) - 0.02) / 3
    assert_allclose(fit.shape.centroid_m, 0, atol=1e-6)
    moved = SupportFunction.from_outline(np.array(SOAP_M), center_of_mass_offset_m=(0.01, -0.002))
    assert_allclose(moved.shape.centroid_m, (-0.01, 0.002), atol=1e-6)

    (tmp_path / "soap.csv").write_text("x_mm;y_mm\n0;0\n60;0\n60;40\n0;40,0\n")
    assert SupportFunction.from_outline(tmp_path / "soap.csv") == fit
    drawing = tmp_path / "soap.svg"
    drawing.write_text('<svg xmlns="http://www.w3.org/2000/svg"><path id="soap" d="M0,0 h60 v40 h-60 z"/></svg>')
    drawn = SupportFunction.from_outline(str(drawing))
    assert_allclose(drawn.shape.harmonics_m, fit.shape.harmonics_m, atol=1e-12)
    assert drawn.notes == [
        'the outline is the path "soap" in line 1; user units are taken for millimetres: 60.0 mm across'
    ]

    notched = SupportFunction.from_outline([*SOAP_M[:3], (0.03, 0.035), SOAP_M[3]])
    assert_allclose(notched.dent_m, 0.005)


def test_names_may_have_sizes() -> None:
    stadium = SupportFunction.named("stadium:60x40")
    assert_allclose(stadium.perimeter_m, 0.04 + 0.04 * np.pi)
    assert_allclose(SupportFunction.named("stadium:60x40", 0.02).mean_radius_m, 0.02)
    assert SupportFunction.named("egg") == SupportFunction.named("egg", 0.03)


def test_outlines_that_are_none_are_refused(tmp_path: Path) -> None:
    with pytest.raises(palpate.ReadError, match="no such file"):
        SupportFunction.from_outline(tmp_path / "soap.csv")
    with pytest.raises(palpate.ShapeError, match="they lie on a line"):
        SupportFunction.from_outline([(0, 0), (1, 1), (2, 2)])
    with pytest.raises(palpate.InputError, match=r"outline must have the shape \(n, 2\)"):
        SupportFunction.from_outline(np.zeros((3, 3)))
