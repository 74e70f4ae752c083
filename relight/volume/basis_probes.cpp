#include "relight/volume/basis_probes.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <glm/gtc/type_ptr.hpp>

#include "scene/float4.h"

namespace pleinair {
namespace {

// Below this a sum is done sooner than a second thread wakes up (some 10 us), or not much later.
constexpr std::size_t kParallelProbes = 4096;
constexpr std::size_t kBlocksPerTask = 256;

bool AnyOf(std::span<const std::uint8_t> marks) {
  return std::any_of(marks.begin(), marks.end(), [](std::uint8_t mark) { return mark != 0; });
}

}  // namespace

BasisProbes::BasisProbes(std::size_t lights, std::size_t probes)
    : lights_(lights), probes_(probes), blocks_((probes + kBlockProbes - 1) / kBlockProbes) {}

void BasisProbes::Set(std::size_t light, std::span<const ShRgb> probes) {
  if (light >= lights_ || probes.size() != probes_) {
    throw std::invalid_argument("basis probes: " + std::to_string(probes.size()) +
                                " probes of light " + std::to_string(light) + ", expected " +
                                std::to_string(probes_) + " of one of " + std::to_string(lights_));
  }
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    const std::size_t first = b * kBlockProbes;
    const std::size_t count = std::min(kBlockProbes, probes_ - first);
    std::array<float, kChannels * kLightFloats> values{};
    for (std::size_t channel = 0; channel < kChannels; ++channel) {
      for (std::size_t j = 0; j < kProbeShCoefficients; ++j) {
        for (std::size_t i = 0; i < count; ++i) {
          values[channel * kLightFloats + j * kBlockProbes + i] =
              probes[first + i][j][static_cast<glm::length_t>(channel)];
        }
      }
    }
    blocks_[b].Set(static_cast<std::uint32_t>(light), values);
  }
}

void BasisProbes::Block::Set(std::uint32_t light,
                             std::span<const float, kChannels * kLightFloats> of_light) {
  const auto place = std::lower_bound(lit.begin(), lit.end(), light);
  const auto index = static_cast<std::size_t>(place - lit.begin());
  const bool was_lit = place != lit.end() && *place == light;
  const bool is_lit =
      std::any_of(of_light.begin(), of_light.end(), [](float value) { return value != 0.0f; });
  // From the last channel to the first, so that the places of those to come stay.
  for (std::size_t channel = kChannels; channel-- > 0;) {
    const auto at =
        values.begin() + static_cast<std::ptrdiff_t>((channel * lit.size() + index) * kLightFloats);
    const auto source = of_light.subspan(channel * kLightFloats, kLightFloats);
    if (was_lit && is_lit) {
      std::copy(source.begin(), source.end(), at);
    } else if (is_lit) {
      values.insert(at, source.begin(), source.end());
    } else if (was_lit) {
      values.erase(at, at + kLightFloats);
    }
  }
  if (is_lit && !was_lit) lit.insert(place, light);
  if (was_lit && !is_lit) lit.erase(place);
}

void BasisProbes::Block::Sum(std::span<const glm::vec3> weights, std::span<ShRgb> sum) const {
  std::array<std::array<Float4, kProbeShCoefficients>, kChannels> of_channel;
  const float* next = values.data();
  for (std::size_t channel = 0; channel < kChannels; ++channel) {
    std::array<Float4, kProbeShCoefficients> total{};
    for (const std::uint32_t light : lit) {
      const float weight = glm::value_ptr(weights[light])[channel];
#pragma GCC unroll 9
      for (std::size_t j = 0; j < kProbeShCoefficients; ++j) {
        total[j] += weight * LoadFour(next + j * kBlockProbes);
      }
      next += kLightFloats;
    }
    of_channel[channel] = total;
  }
  for (std::size_t i = 0; i < sum.size(); ++i) {
    for (std::size_t j = 0; j < kProbeShCoefficients; ++j) {
      sum[i][j] = {of_channel[0][j][i], of_channel[1][j][i], of_channel[2][j][i]};
    }
  }
}

void BasisProbes::Sum(std::span<const glm::vec3> weights,
                      std::span<const std::uint8_t> wanted,
                      std::span<ShRgb> sum) const {
  const auto run = [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) {
      const std::size_t first = b * kBlockProbes;
      const std::size_t count = std::min(kBlockProbes, probes_ - first);
      const std::span<ShRgb> of_block = sum.subspan(first, count);
      if (wanted.empty() || AnyOf(wanted.subspan(first, count))) {
        blocks_[b].Sum(weights, of_block);
      } else {
        std::fill(of_block.begin(), of_block.end(), ShRgb{});
      }
    }
  };
  if (probes_ < kParallelProbes) {
    run(0, blocks_.size());
    return;
  }
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, blocks_.size(), kBlocksPerTask),
                    [&](const auto& range) { run(range.begin(), range.end()); });
}

}  // namespace pleinair
