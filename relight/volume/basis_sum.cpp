#include "relight/volume/basis_sum.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <glm/gtc/type_ptr.hpp>

#include "scene/is_finite.h"

namespace pleinair::internal {
namespace {

// The pattern RGBRGBRGBRGB: the shortest that is a whole number both of pixels and of the 4-float
// registers that every x86-64 and ARM64 has, so that the compiler needs no shuffles.
constexpr std::size_t kPatternPixels = 4;
constexpr std::size_t kPatternFloats = 3 * kPatternPixels;
using Pattern = std::array<float, kPatternFloats>;

// A block of the sum stays in the first-level cache (6 KiB of 32) while all terms are added to it.
constexpr std::size_t kBlockPixels = 512;

// Below this a sum is done sooner than a second thread wakes up (some 10 us).
constexpr std::size_t kParallelPixels = 32768;

Pattern PatternOf(const glm::vec3& weight) {
  Pattern pattern;
  for (std::size_t i = 0; i < kPatternFloats; ++i) {
    pattern[i] = weight[static_cast<glm::length_t>(i % 3)];
  }
  return pattern;
}

void Scale(const float* __restrict source,
           const Pattern& pattern,
           std::size_t count,
           float* __restrict sum) {
  std::size_t i = 0;
  for (; i + kPatternFloats <= count; i += kPatternFloats) {
    for (std::size_t j = 0; j < kPatternFloats; ++j) sum[i + j] = pattern[j] * source[i + j];
  }
  for (std::size_t j = 0; i + j < count; ++j) sum[i + j] = pattern[j] * source[i + j];
}

void AddScaled(const float* __restrict source,
               const Pattern& pattern,
               std::size_t count,
               float* __restrict sum) {
  std::size_t i = 0;
  for (; i + kPatternFloats <= count; i += kPatternFloats) {
    for (std::size_t j = 0; j < kPatternFloats; ++j) sum[i + j] += pattern[j] * source[i + j];
  }
  for (std::size_t j = 0; i + j < count; ++j) sum[i + j] += pattern[j] * source[i + j];
}

struct Term {
  const float* values;
  Pattern pattern;
};

// The same for four terms at `offset`, added one after the other: the sum is read and written once
// for all of them, and no bit of it is another.
void AddFour(const Term* terms, std::size_t offset, std::size_t count, float* __restrict sum) {
  const float* const __restrict a = terms[0].values + offset;
  const float* const __restrict b = terms[1].values + offset;
  const float* const __restrict c = terms[2].values + offset;
  const float* const __restrict d = terms[3].values + offset;
  const Pattern pa = terms[0].pattern;
  const Pattern pb = terms[1].pattern;
  const Pattern pc = terms[2].pattern;
  const Pattern pd = terms[3].pattern;
  std::size_t i = 0;
  for (; i + kPatternFloats <= count; i += kPatternFloats) {
    for (std::size_t j = 0; j < kPatternFloats; ++j) {
      const float first = (sum[i + j] + pa[j] * a[i + j]) + pb[j] * b[i + j];
      sum[i + j] = (first + pc[j] * c[i + j]) + pd[j] * d[i + j];
    }
  }
  for (std::size_t j = 0; i + j < count; ++j) {
    const float first = (sum[i + j] + pa[j] * a[i + j]) + pb[j] * b[i + j];
    sum[i + j] = (first + pc[j] * c[i + j]) + pd[j] * d[i + j];
  }
}

void SumPixels(std::span<const Term> terms, std::size_t begin, std::size_t end, float* sum) {
  for (std::size_t pixel = begin; pixel < end; pixel += kBlockPixels) {
    const std::size_t count = 3 * std::min(kBlockPixels, end - pixel);
    float* const block = sum + 3 * pixel;
    if (terms.empty()) {
      std::fill_n(block, count, 0.0f);
      continue;
    }
    Scale(terms[0].values + 3 * pixel, terms[0].pattern, count, block);
    std::size_t k = 1;
    for (; k + 4 <= terms.size(); k += 4) AddFour(&terms[k], 3 * pixel, count, block);
    for (; k < terms.size(); ++k) {
      AddScaled(terms[k].values + 3 * pixel, terms[k].pattern, count, block);
    }
  }
}

}  // namespace

std::vector<glm::vec3> BasisWeights(const Lighting& lighting,
                                    std::size_t count,
                                    std::string_view what) {
  if (lighting.sky.size() + 1 != count) {
    throw std::invalid_argument(std::string(what) + ": the lighting has a sun and " +
                                std::to_string(lighting.sky.size()) +
                                " sky components, expected as many as the " +
                                std::to_string(count) + " basis lights, sun included");
  }
  std::vector<glm::vec3> weights{glm::vec3(lighting.sun.irradiance_rgb)};
  for (const SkyComponent& sky : lighting.sky) weights.emplace_back(sky.irradiance_rgb);
  for (std::size_t k = 0; k < weights.size(); ++k) {
    if (!IsFinite(weights[k])) {
      throw std::invalid_argument(std::string(what) + ": irradiance_rgb of " +
                                  (k == 0 ? "the sun" : "sky[" + std::to_string(k - 1) + "]") +
                                  " is not a finite single-precision number");
    }
  }
  return weights;
}

void WeightedSum(std::span<const std::span<const glm::vec3>> terms,
                 std::span<const glm::vec3> weights,
                 std::span<glm::vec3> sum,
                 std::string_view what) {
  if (terms.size() != weights.size()) {
    throw std::invalid_argument(std::string(what) + ": " + std::to_string(terms.size()) +
                                " basis lights, expected one for each of " +
                                std::to_string(weights.size()) + " intensities");
  }
  std::vector<Term> lit;
  for (std::size_t k = 0; k < terms.size(); ++k) {
    if (terms[k].empty()) continue;
    if (terms[k].size() != sum.size()) {
      throw std::invalid_argument(std::string(what) + ": basis light " + std::to_string(k) +
                                  " has " + std::to_string(terms[k].size()) +
                                  " entries, expected " + std::to_string(sum.size()));
    }
    lit.push_back({glm::value_ptr(terms[k].front()), PatternOf(weights[k])});
  }
  if (sum.empty()) return;
  float* const out = glm::value_ptr(sum.front());
  if (sum.size() < kParallelPixels) {
    SumPixels(lit, 0, sum.size(), out);
    return;
  }
  // Each pixel is summed alone, in the order of the lights: how they are dealt out can't matter.
  const std::size_t blocks = (sum.size() + kBlockPixels - 1) / kBlockPixels;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, blocks, kParallelPixels / kBlockPixels / 2),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      SumPixels(lit,
                                range.begin() * kBlockPixels,
                                std::min(range.end() * kBlockPixels, sum.size()),
                                out);
                    });
}

}  // namespace pleinair::internal
