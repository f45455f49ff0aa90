"""Hostile values and damaged files for the fuzz tests, and what may come of them."""

from __future__ import annotations

import copy
import json
import os
from collections.abc import Callable
from typing import Any

import numpy as np
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

from glossa import InputError, SolveError

EXAMPLES = int(os.environ.get("GLOSSA_FUZZ", "25"))
"""Examples of each fuzz test; the same ones in every run."""

fuzz = settings(
    max_examples=EXAMPLES, suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture]
)


def only_own_errors(call: Callable[[], Any], *also: type[Exception]) -> Any:
    """The result of a call, or the error of glossa that it raised, with a message; any other exception passes on."""
    own: tuple[type[Exception], ...] = (InputError, SolveError, *also)
    refusal = None
    try:
        result = call()
    except own as error:
        result = refusal = error
    assert refusal is None or str(refusal)
    return result


class _Odd:
    """Has nothing that a number, sequence or mapping has."""


NUMBERS: tuple[Any, ...] = (
    *(0, 1, -1, 2**31, 2**63, -(2**63) - 1, 10**400, True, False, 0.0, -0.0, 0.5, 1.0, -1.0, 5e-324, 1e-300, 1e300),
    *(
        1.7976931348623157e308,
        float("nan"),
        float("inf"),
        -float("inf"),
        1j,
        np.float32(1.5),
        np.int8(3),
        np.bool_(True),
    ),
    *(np.float64("nan"), np.datetime64("NaT"), np.complex128(1j)),
)
OTHERS: tuple[Any, ...] = (
    *(
        None,
        "",
        "i",
        "left",
        "upright",
        "wall:floor",
        "\x00",
        "λ" * 300,
        b"bytes",
        (),
        [],
        {},
        set(),
        {"left"},
        _Odd(),
        _Odd,
    ),
    *([[1, 2], [3]], [None], ["a", 1], [[[1.0]]], {"left": None}, {1: 2}, {"upper": "x"}, range(3), lambda: 0, ...),
)
ARRAYS: tuple[Any, ...] = (
    np.zeros(0),
    np.zeros(3),
    np.full(3, np.nan),
    np.zeros((2, 3)),
    np.zeros((45, 3)),
    np.full((45, 3), 1e200),
    np.zeros((45, 3), dtype=complex),
    np.array(["a", "b"]),
    np.array([None, {}], dtype=object),
    np.zeros((1, 1, 1, 1)),
    np.arange(8),
    np.array(2.0),
)

hostile = st.one_of(
    st.sampled_from(NUMBERS),
    st.sampled_from(OTHERS),
    st.sampled_from(ARRAYS),
    st.floats(),
    st.integers(),
    st.text(max_size=5),
    st.lists(st.floats(), max_size=4),
)
"""Anything that a caller might pass by mistake."""

SPLINTERS: tuple[bytes, ...] = (
    *(b"nan", b"-1", b"1e999", b"99999999999999999999", b"0", b"", b"\xff\xfe", b"\x00", b"[]", b"{}", b"null", b","),
    *(b'"', b"\n", b"/", b"-0.0", b"1e-320", b"9" * 5000, b"[" * 2000, b"'", b"=", b"5.5"),
)
"""What does not belong where it is put."""


@st.composite
def damaged(draw: st.DrawFn, content: bytes) -> bytes:
    """A file with some of its bytes changed, lost, doubled or replaced."""
    data = bytearray(content)
    for _ in range(draw(st.integers(1, 3))):
        at = draw(st.integers(0, max(0, len(data) - 1)))
        length = draw(st.sampled_from((0, 1, 2, 8, 64, 10**9)))
        match draw(st.sampled_from(("flip", "cut", "splinter", "double", "end"))):
            case "flip" if data:
                data[at] ^= 1 << draw(st.integers(0, 7))
            case "cut":
                del data[at : at + length]
            case "splinter":
                data[at : at + min(length, 8)] = draw(st.sampled_from(SPLINTERS))
            case "double":
                data[at:at] = data[at : at + min(length, 64)]
            case _:
                del data[at:]
    return bytes(data)


JSON_VALUES: tuple[Any, ...] = (
    *(None, True, -1, 0, 1, 2**31, 10**30, 0.5, 1e308, float("nan"), float("inf"), "", "x", [], [[]], {}, [1, "a"]),
    *([[1, 2], [3]], {"a": 1}, [None], [[[0.0]]], [1e30], [2**40], [-5]),
)


@st.composite
def damaged_json(draw: st.DrawFn, content: str) -> bytes:
    """A JSON document with some of its values replaced, removed or repeated, anywhere in the tree."""
    document = json.loads(content)
    for _ in range(draw(st.integers(1, 2))):
        parent: Any = None
        key: Any = None
        value = document
        while isinstance(value, dict | list) and value:
            keys = list(value) if isinstance(value, dict) else list(range(len(value)))
            parent, key = value, keys[draw(st.integers(0, len(keys) - 1))]
            value = parent[key]
            if draw(st.booleans()):
                break
        if parent is None:
            break
        match draw(st.sampled_from(("replace", "remove", "repeat"))):
            case "remove":
                del parent[key]
            case "repeat" if isinstance(parent, list):
                parent.append(copy.deepcopy(parent[key]))
            case _:
                parent[key] = copy.deepcopy(draw(st.sampled_from(JSON_VALUES)))
    return json.dumps(document).encode()
