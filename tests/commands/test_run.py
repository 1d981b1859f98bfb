"""What a person sees of a job's progress."""

from io import StringIO
from itertools import pairwise

from slider.commands import run


def test_a_long_job_says_ever_less_on_the_terminal_and_everything_in_its_log(monkeypatch, capsys):
    now = 0.0
    monkeypatch.setattr(run.time, "monotonic", lambda: now)
    terminal = StringIO()
    show = run.progress_lines("walking", terminal)
    times = []
    for second in range(1, 601):
        now, before = float(second), len(terminal.getvalue())
        show(f"{second} s")
        if len(terminal.getvalue()) > before:
            times.append(second)
    assert times[:4] == [5, 10, 15, 20]
    gaps = [late - early for early, late in pairwise(times)]
    assert gaps == sorted(gaps)
    assert gaps[-1] == 30
    assert len(capsys.readouterr().out.splitlines()) == 600
    assert terminal.getvalue().startswith("walking: 5 s\n")
