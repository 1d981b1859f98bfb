"""Files from the future get the time of now, others keep theirs."""

import os
import time

from slider.artefacts.maintenance import date_now
from slider.artefacts.store import Store


def test_only_what_is_from_the_future_is_dated(tmp_path):
    store, late, early = Store(tmp_path), tmp_path / "late.json", tmp_path / "early.json"
    now = time.time()
    for path, moment in ((late, now + 3600), (early, now - 3600)):
        path.write_text("{}")
        os.utime(path, (moment, moment))
    assert date_now(store, [late, early, tmp_path / "absent.json"]) == 1
    assert abs(late.stat().st_mtime - now) < 60
    assert abs(early.stat().st_mtime - now + 3600) < 1
    assert date_now(store, [late, early]) == 0
