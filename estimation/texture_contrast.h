// How deep the shadows are that rough surfaces (leaves, grass, gravel) cast on themselves.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "estimation/diffuse_sample.h"
#include "estimation/sky_climate.h"
#include "scene/camera.h"
#include "scene/frame.h"

namespace pleinair {

// Standard deviations of the logarithm of radiance within squares of kTextureWindowPx, the median
// over the samples.
struct TextureContrast {
  double now = 0.0;
  double most = 0.0;  // That this camera has seen so far, `now` among them.
};

inline constexpr int kTextureWindowPx = 17;

// nullopt where hardly any sample's square is usable. Radiance in any unit; green alone is read.
std::optional<double> FineContrast(const Frame& frame, std::span<const DiffuseSample> samples);

// Under each state of the sky, as logarithms. Deep fine contrast is the sun's; contrast that was
// deep and is no longer is the sun's that is gone. Smooth surfaces say nothing.
//
// Source  Contrast as a feature of sunny and cloudy pictures: Lu, Lin, Jia and Tang, CVPR 2014. The
//         figures are assumptions.
std::array<double, kSkyStates> LogLikelihood(const TextureContrast& contrast);

// Remembers the most that one camera has seen. One thread at a time.
class TextureWatch {
 public:
  // Of another camera than the last frame's it knows nothing yet.
  std::optional<TextureContrast> Look(const Frame& frame,
                                      const Camera& camera,
                                      std::span<const DiffuseSample> samples);

 private:
  std::optional<Camera> camera_;
  double most_ = 0.0;
};

}  // namespace pleinair
