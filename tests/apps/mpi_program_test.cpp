// The same job by one process and by ranks.

#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>

#include <gtest/gtest.h>

#include "tests/scene/temporary_folder.h"

namespace pleinair::mpi_program_test {
namespace {

std::string ContentOf(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

bool Runs(const std::string& command) {
  const int status = std::system((command + " > /dev/null 2>&1").c_str());
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

// A trench of two walls, seen by 100 regions: four blocks of lights, and as many shares of faces.
TEST(MpiProgram, FourRanksGiveOnesBits) {
  const std::string program = PLEINAIR_MPI_PROGRAM;
  if (program.empty()) GTEST_SKIP() << "built without MPI";
  if (!Runs("mpirun --version")) GTEST_SKIP() << "no mpirun here";
  const TemporaryFolder folder;
  folder.Write("trench.obj",
               "v -4 -4 0\nv 4 -4 0\nv 4 4 0\nv -4 4 0\n"
               "v -1 -4 0\nv -1 4 0\nv -1 4 2\nv -1 -4 2\n"
               "v 1 -4 0\nv 1 4 0\nv 1 4 2\nv 1 -4 2\n"
               "f 1 2 3 4\nf 5 6 7 8\nf 12 11 10 9\n");
  folder.Write("points.json", R"({"points": [[0, 0, 0.1]], "normals": [[0, 0, 1], [1, 0, 0]]})");
  const auto arguments = [&](const std::string& out) {
    return " irradiance --scene " + (folder / "trench.obj").string() + " --points " +
           (folder / "points.json").string() + " --out " + (folder / out).string() + " --cache " +
           (folder / "cache").string() +
           " --sky-regions 5x20 --light indirect --patch-size 0.5 --patch-rays 64"
           " --patch-sky-rays 3200 --rays 256";
  };
  // MPI itself leaves memory behind: a leak checker would blame the program for it.
  const std::string ranks =
      "ASAN_OPTIONS=detect_leaks=0 mpirun --allow-run-as-root --oversubscribe -n ";
  ASSERT_TRUE(Runs(PLEINAIR_PROGRAM + arguments("alone.json")));
  ASSERT_TRUE(Runs(ranks + "1 " + program + arguments("one.json")));
  ASSERT_TRUE(Runs(ranks + "4 " + program + arguments("four.json")));
  const std::string alone = ContentOf(folder / "alone.json");
  EXPECT_FALSE(alone.empty());
  EXPECT_EQ(ContentOf(folder / "one.json"), alone);
  EXPECT_EQ(ContentOf(folder / "four.json"), alone);
  // What ranks can't share they refuse, all of them.
  EXPECT_FALSE(Runs(ranks + "2 " + program + " sun --site 50,7 --time 2026-06-21T12:00:00Z"));
}

}  // namespace
}  // namespace pleinair::mpi_program_test
