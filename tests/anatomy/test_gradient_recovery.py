"""Recovered gradients: exact for linear fields, errors of quadratic ones."""

from __future__ import annotations

import numpy as np
import pytest
from tests.blocks import block

from glossa.anatomy.gradient_recovery import gradient_errors
from glossa.anatomy.hexahedra import gauss_gradients

SLOPES = np.array([[1.0, 2.0, 0.0], [0.0, -1.0, 0.5], [3.0, 0.0, 0.0]])


def test_gradients_of_linear_fields() -> None:
    body = block((3, 2, 2), distortion=0.2)
    found = gauss_gradients(body.nodes, body.nodes @ SLOPES.T, body.hexahedra)
    assert np.allclose(found, SLOPES, rtol=0.0, atol=1e-12)


def test_linear_fields_have_no_error() -> None:
    body = block((3, 2, 2), distortion=0.2)
    assert gradient_errors(body.nodes, body.nodes @ SLOPES.T, body.hexahedra) == pytest.approx(0.0, abs=1e-12)


def test_error_of_a_quadratic_field() -> None:
    """The gradient 2 c x of c x^2 is constant in a hexahedron of length h: root mean square error 2 c h / sqrt(12)."""
    body = block((10, 2, 2), (0.1, 0.02, 0.02))
    field = np.zeros_like(body.nodes)
    field[:, 1] = 5.0 * body.nodes[:, 0] ** 2
    found = gradient_errors(body.nodes, field, body.hexahedra)
    assert found == pytest.approx(10.0 * 0.01 / np.sqrt(12.0), rel=1e-9)
