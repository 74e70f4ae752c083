#!/usr/bin/python3
"""Fails when a folder knows a folder that stands below it.

The folders are layers in a fixed order; CMakeLists.txt holds the one list. A file may include its own
folder and the folders above it. Beyond the order: nobody includes another folder's internal/, nor another room's,
estimation never sees a mesh or a GL handle, render never sees a camera driver or a solver, and only
apps prints. Tests of the libraries, and benches, do without apps. The CMake links are held to the
same order.

Usage: check_layering.py ROOT FOLDER...    with the folders from the lowest layer to the highest
"""

import re
import sys
from pathlib import Path

SOURCES = {".h", ".cpp"}
TEST_ROOTS = ("tests", "bench")
# Tests of the programs: the only ones that may include the last folder, apps.
TESTS_OF_PROGRAMS = ("apps", "viewer", "camera", "camera_stand_in")
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]')
LINKED = re.compile(r"\bpleinair(?:::|_)([a-z]+)\b")

# Folder -> what its includes may not start with, and why.
FORBIDDEN = {
    "estimation": (
        ("scene/mesh", "scene/ray_caster", "embree", "assimp", "epoxy/", "EGL/", "GL/", "GLES", "GLFW/"),
        "estimation never sees a mesh or a GL handle",
    ),
    "render": (
        ("estimation/", "datasets/", "ceres/", "libcamera/", "libv4l", "linux/videodev2"),
        "render never sees a camera driver or a solver",
    ),
}
PRINTING = ("iostream", "print")


def includes_of(path):
    """Yields (line number, included path), with block comments taken out."""
    text = path.read_text(encoding="utf-8", errors="replace")
    text = re.sub(r"/\*.*?\*/", lambda match: "\n" * match.group().count("\n"), text, flags=re.DOTALL)
    for number, line in enumerate(text.split("\n"), start=1):
        match = INCLUDE.match(line)
        if match:
            yield number, match.group(1)


def why_not(home, included, order):
    """Returns why a file in folder `home` (of a test, the folder that it tests; None: of bench/) may
    not include this path, or None."""
    if included.startswith("../") or "/../" in included:
        return "includes are written from the root, without '..'"
    target = included.partition("/")[0]
    if target in order:
        owner, inside, _ = included.rpartition("/internal/")
        if inside and not f"{home}/".startswith(f"{owner}/"):
            return f"{owner}/internal/ belongs to {owner} alone"
    return None


def why_not_in_test(test_root, tested, included, order):
    """A test may look into every room of the folder that it tests."""
    programs = order[-1]
    if included.startswith(f"{programs}/"):
        if test_root == "bench":
            return f"benches do not include {programs}"
        if tested not in TESTS_OF_PROGRAMS:
            return f"tests of {tested} do not include {programs}"
    home = included.rpartition("/internal/")[0] if included.startswith(f"{tested}/") else None
    return why_not(home, included, order)


def why_not_in_layer(own, included, order):
    """The further rules for the layers themselves: tests and benches are free of them."""
    target = included.partition("/")[0]
    if target in TEST_ROOTS:
        return f"{target}/ is no part of a library"
    if target in order and order.index(target) > order.index(own):
        return f"{own} stands above {target} and may not know it"
    prefixes, reason = FORBIDDEN.get(own, ((), ""))
    if included.startswith(prefixes) and prefixes:
        return reason
    if own != order[-1] and included in PRINTING:
        return f"libraries do not print; only {order[-1]} does"
    return None


def sources_under(folder):
    return sorted(path for path in folder.rglob("*") if path.suffix in SOURCES and path.is_file())


def include_faults(root, order):
    for own in order:
        for path in sources_under(root / own):
            for number, included in includes_of(path):
                home = path.parent.relative_to(root).as_posix()
                reason = why_not(home, included, order) or why_not_in_layer(own, included, order)
                if reason:
                    yield f"{path.relative_to(root)}:{number}: includes {included}: {reason}"
    for test_root in TEST_ROOTS:
        for path in sources_under(root / test_root):
            parts = path.relative_to(root / test_root).parts
            for number, included in includes_of(path):
                reason = why_not_in_test(test_root, parts[0], included, order)
                if reason:
                    yield f"{path.relative_to(root)}:{number}: includes {included}: {reason}"


def link_faults(root, order):
    for own in order:
        for path in sorted((root / own).rglob("CMakeLists.txt")):
            for number, line in enumerate(path.read_text(encoding="utf-8").split("\n"), start=1):
                for target in LINKED.findall(line.split("#")[0]):
                    if target in order and order.index(target) > order.index(own):
                        yield (
                            f"{path.relative_to(root)}:{number}: names pleinair::{target}: "
                            f"{own} stands above {target} and may not link it"
                        )


def main(arguments):
    if len(arguments) < 3:
        print(__doc__, file=sys.stderr)
        return 2
    root, order = Path(arguments[1]), arguments[2:]
    seen = sum(len(sources_under(root / folder)) for folder in order)
    if seen == 0:
        print(f"{root}: no sources in any of {', '.join(order)}: wrong root?", file=sys.stderr)
        return 2
    faults = [*include_faults(root, order), *link_faults(root, order)]
    for fault in faults:
        print(fault)
    print(f"layering: {seen} files in {len(order)} folders, {len(faults)} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv))
