// The probes of many basis lights, laid out so that their sum is one read from front to back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "scene/spherical_harmonics.h"

namespace pleinair {

// Four neighbouring probes are a block. All that a block needs lies together, a channel and a light
// at a time, so that its sums stay in registers. Lights that leave a block dark (in a room, those
// behind its walls) take neither room nor time.
class BasisProbes {
 public:
  BasisProbes() = default;
  BasisProbes(std::size_t lights, std::size_t probes);

  std::size_t Lights() const { return lights_; }
  // Replaces what light `light` makes of all probes; before that it makes nothing. Throws
  // std::invalid_argument for another number of probes or no such light.
  void Set(std::size_t light, std::span<const ShRgb> probes);

  // Writes sum_k weights[k] * probes of light k, channel by channel, lights in their order.
  // Where `wanted` is not empty, blocks without a probe that it marks are left black.
  //
  // Shape    weights: one a light; wanted: empty, or one a probe; sum: one a probe. Unchecked.
  // Cost     bound by memory: 108 bytes a probe and light. Allocates nothing. Large sums are spread
  //          over threads, which changes no bit of them.
  void Sum(std::span<const glm::vec3> weights,
           std::span<const std::uint8_t> wanted,
           std::span<ShRgb> sum) const;

 private:
  static constexpr std::size_t kBlockProbes = 4;
  static constexpr std::size_t kChannels = 3;
  static constexpr std::size_t kLightFloats = kProbeShCoefficients * kBlockProbes;

  struct Block {
    std::vector<std::uint32_t> lit;  // Lights that are not black here, ascending.
    std::vector<float> values;       // [channel][place in lit][coefficient][probe].

    void Set(std::uint32_t light, std::span<const float, kChannels * kLightFloats> of_light);
    void Sum(std::span<const glm::vec3> weights, std::span<ShRgb> sum) const;
  };

  std::size_t lights_ = 0;
  std::size_t probes_ = 0;
  std::vector<Block> blocks_;
};

}  // namespace pleinair
