"""A job takes its plan by the digest of the file, and checks its own recipe alone."""

import pytest

from slider.artefacts.plan import JobSpec, build_plan, read_plan, write_plan
from slider.artefacts.recipe import Code
from slider.cli import main
from slider.core import files
from slider.core.errors import UserError

JOB = JobSpec("gait", "a gait", Code("slider.none:run", "abc", {}), {"value": 1})


def test_a_recipe_that_does_not_fit_its_job_is_refused(tmp_path, capsys):
    path = write_plan(build_plan({"table1": JOB}), tmp_path)
    other = "0" * 64
    text = path.read_text().strip().replace(JOB.recipe, other)
    path.write_text(text)
    with pytest.raises(UserError, match="expected a plan"):
        read_plan(path)
    named = path.rename(path.with_stem(files.digest_text(text)))
    assert main(["run", other, "--plan", str(named), "--artefacts", str(tmp_path)]) == 1
    assert capsys.readouterr().err == f"slider: expected a recipe of {named}, found {other}\n"
