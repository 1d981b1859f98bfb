"""Tables of foot placement as files."""

from dataclasses import fields

import numpy as np
import pytest

from slider.core.errors import UserError
from slider.hzd.gains import FootPlacement


def test_what_is_saved_is_loaded_and_a_missing_table_is_one_line(tmp_path):
    rng = np.random.default_rng(0)
    tables = FootPlacement(*(rng.standard_normal((2, k + 1)) for k in range(7)))
    with pytest.raises(UserError, match=r"expected velocities.npy of the foot placement"):
        FootPlacement.load(tmp_path)
    tables.save(tmp_path)
    found = FootPlacement.load(tmp_path)
    for field in fields(FootPlacement):
        np.testing.assert_array_equal(getattr(found, field.name), getattr(tables, field.name))
