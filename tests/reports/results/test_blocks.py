"""Marks of result blocks: found outside code, filled, and an edit by hand shows."""

import pytest

from slider.core.errors import UserError
from slider.reports.results.blocks import fill, find

PAGE = """\
# Page

```
<!-- results: code -->
```

<!-- results: one -->
old
<!-- /results -->
Between.
<!-- results: two -->
<!-- /results -->
"""


def test_blocks_are_found_outside_code():
    assert [(block.name, block.body) for block in find(PAGE)] == [("one", "old"), ("two", "")]


def test_filling_changes_the_blocks_and_nothing_else():
    one, two = find(PAGE)
    filled = fill(PAGE, {two: "2\n\n2", one: "1"})
    assert [block.body for block in find(filled)] == ["1", "2\n\n2"]
    assert not any(block.edited for block in find(filled))
    kept = [line for line in filled.splitlines() if line and "results" not in line]
    assert kept == ["# Page", "```", "```", "1", "Between.", "2", "2"]


def test_filling_again_changes_nothing():
    filled = fill(PAGE, dict.fromkeys(find(PAGE), "| a |\n|---|\n| 1 |"))
    again = fill(filled, {block: block.body for block in find(filled)})
    assert again == filled


def test_an_edit_by_hand_shows():
    filled = fill(PAGE, dict.fromkeys(find(PAGE), "success 91 %"))
    first, second = find(filled.replace("91", "99", 1))
    assert first.edited
    assert not second.edited


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<!-- results: a -->\n", "line 1: expected the end of block a, found none"),
        (
            "<!-- /results -->\n",
            "line 1: expected the other mark of a block, found <!-- /results -->",
        ),
        (
            "<!-- results: a -->\n<!-- results: b -->\n<!-- /results -->\n",
            "line 2: expected the other mark of a block, found <!-- results: b -->",
        ),
    ],
)
def test_a_mark_without_its_partner_is_refused(text, message):
    with pytest.raises(UserError, match=f"^{message}$"):
        find(text)
