#!/usr/bin/python3
"""The layering check must fail where it should: each case is a small tree made for it."""

import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

CHECK = Path(__file__).with_name("check_layering.py")
ORDER = ["scene", "estimation", "render", "apps"]


def check(files):
    """Returns (exit status, output) of the check over a tree of {path: text}."""
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        for path, text in {"scene/image.h": "#include <vector>\n", **files}.items():
            (root / path).parent.mkdir(parents=True, exist_ok=True)
            (root / path).write_text(text, encoding="utf-8")
        done = subprocess.run(
            [sys.executable, CHECK, root, *ORDER], capture_output=True, text=True, check=False
        )
        return done.returncode, done.stdout + done.stderr


class CheckLayering(unittest.TestCase):
    def assert_fault(self, files, words):
        status, output = check(files)
        self.assertEqual(status, 1, output)
        self.assertIn(words, output)

    def assert_clean(self, files):
        status, output = check(files)
        self.assertEqual(status, 0, output)

    def test_passes_downward_own_and_foreign_includes(self):
        self.assert_clean({
            "render/compositor.cpp": '#include "render/internal/pass.h"\n#include "scene/image.h"\n',
            "apps/main.cpp": '#include "render/compositor.h"\n#include <iostream>\n',
            "estimation/fit.cpp": "#include <ceres/ceres.h>\n",
        })

    def test_fails_on_an_upward_include_and_says_where(self):
        self.assert_fault(
            {"scene/image.cpp": '#include "scene/image.h"\n\n  #  include "render/pass.h"\n'},
            "scene/image.cpp:3: includes render/pass.h",
        )

    def test_fails_on_an_upward_include_in_angle_brackets(self):
        self.assert_fault({"scene/image.cpp": "#include <apps/arguments.h>\n"}, "apps/arguments.h")

    def test_fails_on_an_upward_include_in_an_internal_header(self):
        self.assert_fault({"scene/internal/a.h": '#include "render/a.h"\n'}, "scene/internal/a.h:1")

    def test_fails_on_a_way_around_the_root(self):
        self.assert_fault({"scene/image.cpp": '#include "../render/pass.h"\n'}, "without '..'")

    def test_fails_on_the_internals_of_another_folder(self):
        faulty = '#include "scene/internal/texel.h"\n'
        self.assert_fault({"render/pass.cpp": faulty}, "belongs to scene alone")
        self.assert_fault({"tests/render/pass_test.cpp": faulty}, "belongs to scene alone")
        self.assert_clean({"tests/scene/texel_test.cpp": faulty})

    def test_fails_on_the_internals_of_another_room(self):
        faulty = '#include "scene/maps/internal/texel.h"\n'
        self.assert_fault({"scene/image.cpp": faulty}, "belongs to scene/maps alone")
        self.assert_fault({"scene/rays/ray.cpp": faulty}, "belongs to scene/maps alone")
        self.assert_clean({"scene/maps/map.cpp": faulty, "scene/maps/internal/a.cpp": faulty})
        self.assert_clean({"tests/scene/texel_test.cpp": faulty})
        self.assert_clean({"scene/maps/map.cpp": '#include "scene/internal/bits.h"\n'})

    def test_fails_when_estimation_sees_a_mesh_or_gl(self):
        for header in ("scene/mesh.h", "scene/ray_caster.h", "embree3/rtcore.h", "epoxy/gl.h"):
            self.assert_fault({"estimation/fit.cpp": f"#include <{header}>\n"}, "never sees a mesh")

    def test_fails_when_render_sees_a_solver(self):
        self.assert_fault({"render/pass.cpp": "#include <ceres/ceres.h>\n"}, "or a solver")
        self.assert_fault({"render/pass.cpp": '#include "estimation/fit.h"\n'}, "or a solver")

    def test_fails_when_a_library_prints(self):
        self.assert_fault({"scene/image.cpp": "#include <iostream>\n"}, "do not print")

    def test_fails_when_a_library_includes_a_test(self):
        self.assert_fault({"scene/image.cpp": '#include "tests/scene/a.h"\n'}, "no part of a library")

    def test_fails_when_a_test_of_a_library_or_a_bench_includes_a_program(self):
        faulty = '#include "apps/arguments.h"\n'
        self.assert_fault({"tests/render/pass_test.cpp": faulty}, "tests of render do not include apps")
        self.assert_fault({"bench/pass_bench.cpp": faulty}, "benches do not include apps")
        self.assert_fault({"bench/apps/pass_bench.cpp": faulty}, "benches do not include apps")
        for program in ("apps", "viewer", "camera", "camera_stand_in"):
            self.assert_clean({f"tests/{program}/arguments_test.cpp": faulty})

    def test_fails_on_an_upward_link(self):
        self.assert_fault(
            {"scene/CMakeLists.txt": "# pleinair::apps\npleinair_add_library(scene\n  PRIVATE pleinair::render)\n"},
            "scene/CMakeLists.txt:3: names pleinair::render",
        )

    def test_passes_downward_links(self):
        self.assert_clean({"render/CMakeLists.txt": "pleinair_add_library(render PUBLIC pleinair::scene)\n"})

    def test_does_not_take_comments_for_includes(self):
        self.assert_clean({
            "scene/image.cpp": '// #include "render/a.h"\n/*\n#include "render/b.h"\n*/\n',
        })

    def test_refuses_a_root_without_sources(self):
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([sys.executable, CHECK, folder, *ORDER], capture_output=True, check=False)
        self.assertEqual(done.returncode, 2)


if __name__ == "__main__":
    unittest.main()
