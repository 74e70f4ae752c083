// Sums of basis lights' probes, against the plain double loop.

#include <random>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "relight/volume/basis_probes.h"

namespace pleinair::basis_probes_test {
namespace {

using Probes = std::vector<ShRgb>;

Probes RandomProbes(std::size_t count, std::mt19937& random) {
  std::uniform_real_distribution<float> value(-1.0f, 1.0f);
  Probes probes(count);
  for (ShRgb& probe : probes) {
    for (glm::vec3& coefficient : probe) {
      coefficient = {value(random), value(random), value(random)};
    }
  }
  return probes;
}

Probes PlainSum(const std::vector<Probes>& lights, const std::vector<glm::vec3>& weights) {
  Probes sum(lights[0].size(), ShRgb{});
  for (std::size_t light = 0; light < lights.size(); ++light) {
    for (std::size_t probe = 0; probe < sum.size(); ++probe) {
      for (std::size_t j = 0; j < sum[probe].size(); ++j) {
        sum[probe][j] += weights[light] * lights[light][probe][j];
      }
    }
  }
  return sum;
}

// A last block that is not full, and lights that are dark in some blocks, in all, and in none. The
// order of the sum is the same, so no bit may differ.
TEST(BasisProbes, SumsAreThoseOfThePlainLoop) {
  constexpr std::size_t kProbes = 11;
  std::mt19937 random(3);
  std::vector<Probes> lights;
  BasisProbes basis(5, kProbes);
  for (std::size_t light = 0; light < 5; ++light) {
    lights.push_back(RandomProbes(kProbes, random));
    for (std::size_t probe = 0; probe < kProbes; ++probe) {
      if (light == 1 || (light == 3 && probe < 8)) lights[light][probe] = ShRgb{};
    }
  }
  for (const std::size_t light : {2u, 0u, 4u, 1u, 3u}) basis.Set(light, lights[light]);
  const std::vector<glm::vec3> weights{
      {1, 2, 3}, {4, 5, 6}, {0, -1, 0.5f}, {7, 8, 9}, {0.1f, 0.2f, 0.3f}};
  Probes sum(kProbes);
  basis.Sum(weights, {}, sum);
  EXPECT_EQ(sum, PlainSum(lights, weights));

  // Lights that go dark, come back, and change.
  lights[0].assign(kProbes, ShRgb{});
  std::swap(lights[1], lights[2]);
  for (std::size_t light = 0; light < 5; ++light) basis.Set(light, lights[light]);
  basis.Sum(weights, {}, sum);
  EXPECT_EQ(sum, PlainSum(lights, weights));
}

TEST(BasisProbes, UnwantedBlocksAreBlackAndOthersComplete) {
  constexpr std::size_t kProbes = 12;
  std::mt19937 random(5);
  BasisProbes basis(2, kProbes);
  basis.Set(0, RandomProbes(kProbes, random));
  basis.Set(1, RandomProbes(kProbes, random));
  const std::vector<glm::vec3> weights{glm::vec3(1.0f), glm::vec3(2.0f)};
  Probes all(kProbes), some(kProbes, ShRgb{glm::vec3(9.0f)});
  basis.Sum(weights, {}, all);
  std::vector<std::uint8_t> wanted(kProbes, 0);
  wanted[6] = 1;
  basis.Sum(weights, wanted, some);
  for (std::size_t probe = 0; probe < kProbes; ++probe) {
    EXPECT_EQ(some[probe], probe / 4 == 1 ? all[probe] : ShRgb{}) << probe;
  }
}

TEST(BasisProbes, RefusesWhatDoesNotFit) {
  BasisProbes basis(2, 3);
  EXPECT_THROW(basis.Set(2, Probes(3)), std::invalid_argument);
  EXPECT_THROW(basis.Set(0, Probes(4)), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::basis_probes_test
