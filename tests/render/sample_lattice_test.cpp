// Samples of pixels: as many in each, at the same places, none in a row or column of another's.
#include "render/internal/sample_lattice.h"

#include <cmath>
#include <set>
#include <stdexcept>
#include <utility>

#include <gtest/gtest.h>
#include <glm/vec4.hpp>

namespace pleinair::test::sample_lattice_test {
namespace {

// Where the middle of sample `at` lies among the pixels, by the clip coordinates of both pictures.
glm::dvec2 PlaceOf(const SampleLattice& lattice, const glm::ivec2& at) {
  const glm::dvec2 clip = 2.0 * (glm::dvec2(at) + 0.5) / glm::dvec2(lattice.Size()) - 1.0;
  const glm::dvec4 of_pixels =
      glm::inverse(lattice.ClipFromPixelsClip()) * glm::dvec4(clip, 0.0, 1.0);
  return 0.5 * (glm::dvec2(of_pixels) + 1.0) * glm::dvec2(lattice.Pixels());
}

TEST(SampleLattice, EachPixelHasItsSamplesToItself) {
  for (const int side : {2, 4, 6, 8}) {
    const SampleLattice lattice(side, {5, 3});
    ASSERT_EQ(lattice.Offsets().size(), static_cast<std::size_t>(lattice.PerPixel()));
    std::set<std::pair<int, int>> taken;
    for (int y = 0; y < 3; ++y) {
      for (int x = 0; x < 5; ++x) {
        for (const glm::ivec2& offset : lattice.Offsets()) {
          const glm::ivec2 at = lattice.Of({x, y}) + offset;
          EXPECT_TRUE(taken.emplace(at.x, at.y).second);
          EXPECT_GE(at.x, 0);
          EXPECT_GE(at.y, 0);
          EXPECT_LT(at.x, lattice.Size().x);
          EXPECT_LT(at.y, lattice.Size().y);
          const glm::dvec2 place = PlaceOf(lattice, at);
          EXPECT_EQ(std::floor(place.x), x) << "side " << side;
          EXPECT_EQ(std::floor(place.y), y) << "side " << side;
        }
      }
    }
  }
}

// A turned picture of a long strip would be mostly corners.
TEST(SampleLattice, IsNotTurnedWhereThatIsWasteful) {
  EXPECT_EQ(SampleLattice(4, {100, 300}).Turn(), 1);
  for (const glm::ivec2& pixels : {glm::ivec2(4096, 60), glm::ivec2(3, 900)}) {
    const SampleLattice lattice(4, pixels);
    EXPECT_EQ(lattice.Turn(), 0);
    EXPECT_EQ(lattice.Size(), 4 * pixels);
    EXPECT_EQ(lattice.Offsets().size(), 16u);
    EXPECT_EQ(lattice.Of({2, 5}), glm::ivec2(8, 20));
  }
}

TEST(SampleLattice, RefusesSidesThatPutSamplesOnEdges) {
  for (const int side : {-2, 0, 1, 3, 10}) {
    EXPECT_THROW(SampleLattice(side, {4, 4}), std::invalid_argument) << side;
  }
}

// Their mean is the pixel's middle, and each has a row and a column of its own, evenly apart.
TEST(SampleLattice, AnEdgePassesThemOneByOne) {
  for (const int side : {2, 4, 6, 8}) {
    const SampleLattice lattice(side, {1, 1});
    ASSERT_EQ(lattice.Turn(), 1);
    std::set<long> columns;
    std::set<long> rows;
    glm::dvec2 mean(0.0);
    for (const glm::ivec2& offset : lattice.Offsets()) {
      const glm::dvec2 place = PlaceOf(lattice, lattice.Of({0, 0}) + offset);
      const double count = lattice.PerPixel();
      mean += place / count;
      columns.insert(std::lround(count * place.x * 2.0));
      rows.insert(std::lround(count * place.y * 2.0));
    }
    EXPECT_EQ(columns.size(), lattice.Offsets().size());
    EXPECT_EQ(rows.size(), lattice.Offsets().size());
    EXPECT_NEAR(mean.x, 0.5, 1e-9);
    EXPECT_NEAR(mean.y, 0.5, 1e-9);
  }
}

}  // namespace
}  // namespace pleinair::test::sample_lattice_test
