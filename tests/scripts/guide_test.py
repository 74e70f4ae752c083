#!/usr/bin/env python3
"""Does what docs/first-courtyard.md says, as a new user would: its indented lines are run in order.

Usage: guide_test.py SOURCE_DIR BIN_DIR WORK_DIR

The guide begins in the folder of the sources, with the program at build/release/bin. WORK_DIR gets
both as links, and is the home folder, with an empty cache. Blocks between ``` are outputs and
options; they are not run.
"""

import json
import os
import pathlib
import shutil
import subprocess
import sys


def commands_of(page: str) -> str:
    lines, is_fenced = [], False
    for line in page.splitlines():
        if line.startswith("```"):
            is_fenced = not is_fenced
        elif line.startswith("    ") and not is_fenced:
            lines.append(line[4:])
    return "\n".join(lines) + "\n"


def camera_position(file: pathlib.Path) -> list:
    pose = json.loads(file.read_text())["camera"]["camera_from_world"]
    return [-sum(pose[j][i] * pose[j][3] for j in range(3)) for i in range(3)]


def main() -> int:
    source, programs, work = (pathlib.Path(argument).resolve() for argument in sys.argv[1:])
    shutil.rmtree(work, ignore_errors=True)
    (work / "sources/build/release").mkdir(parents=True)
    (work / "sources/build/release/bin").symlink_to(programs)
    (work / "sources/datasets").symlink_to(source / "datasets")
    page = (source / "docs/first-courtyard.md").read_text()
    script = "set -ex\n" + commands_of(page)
    assert script.count("pleinair ") > 10, script
    environment = {name: value for name, value in os.environ.items() if name != "DISPLAY"}
    environment.update(HOME=str(work), XDG_CACHE_HOME=str(work / "cache"))
    run = subprocess.run(
        ["bash", "-c", script],
        cwd=work / "sources",
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    print(run.stdout)
    assert run.returncode == 0, f"a command of the guide ended with {run.returncode}"
    # Lines that the guide prints of the outputs.
    quoted = [line for line in page.splitlines() if line.startswith(("rms ", "nothing is found"))]
    assert len(quoted) == 2, quoted
    for line in quoted:
        assert line in run.stdout, line

    result = work / "first-courtyard"
    found = camera_position(result / "yard/site.json")
    stated = camera_position(source / "datasets/samples/courtyard/sequence.json")
    # Three of the deviations that the guide prints.
    assert max(abs(a - b) for a, b in zip(found, stated)) < 3 * 0.066, (found, stated)
    for name in "live", "result":
        frames = (result / name / "lighting.jsonl").read_text().splitlines()
        assert frames, name
        assert all(json.loads(frame).get("sun_observable") for frame in frames), name
        assert (result / name / "report.html").stat().st_size > 10000
    assert (result / "result/composite.mp4").stat().st_size > 0
    assert (result / "check/day.png").stat().st_size > 0
    return 0


if __name__ == "__main__":
    sys.exit(main())
