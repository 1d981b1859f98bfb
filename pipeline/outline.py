"""Lay out configurations without a store of results, for ``slider lineage``.

``python -m pipeline.outline TARGET FOLDER OVERRIDES ...`` writes the plan of each configuration
below its folder, as Snakemake does below ``artefacts/``.
"""

import sys
from pathlib import Path

from pipeline.entry import OPTION, parse_overrides, planned
from slider.artefacts.plan import write_plan
from slider.core.errors import UserError

_CONF = Path(__file__).parents[1] / "conf"


def main(target: str, *outlines: str) -> int:
    """Write the plans; bad input is one line and status 1.

    Args:
        target: laid out also where only somebody who asks for it gets it.
        outlines: folder and overrides, by turns.
    """
    try:
        for folder, text in zip(outlines[::2], outlines[1::2], strict=True):
            _, plan = planned(parse_overrides({OPTION: text}), _CONF, target)
            write_plan(plan, Path(folder) / "plans")
    except UserError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
