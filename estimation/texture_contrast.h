// The depth of the shadows that rough surfaces (leaves, grass, gravel) cast on themselves.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "estimation/diffuse_sample.h"
#include "estimation/sky_climate.h"
#include "scene/camera.h"
#include "scene/frame.h"

namespace pleinair {

// Standard deviations of the logarithm of radiance within squares of kTextureWindowPx; medians over
// the samples.
struct TextureContrast {
  double now = 0.0;
  double most = 0.0;  // The most that this camera has shown so far, `now` included.
};

inline constexpr int kTextureWindowPx = 17;

// Contrast of one frame; nullopt where hardly any sample's square is usable. Radiance in any unit;
// only green is read.
std::optional<double> FineContrast(const Frame& frame, std::span<const DiffuseSample> samples);

// Log-likelihood under each state of the sky. Deep fine contrast is evidence of the sun; contrast
// that was deep and no longer is, is evidence that the sun is gone. Smooth surfaces are no
// evidence.
//
// Source  Contrast as a feature of sunny and cloudy pictures: Lu, Lin, Jia and Tang, CVPR 2014. The
//         figures are assumptions.
std::array<double, kSkyStates> LogLikelihood(const TextureContrast& contrast);

// Keeps the largest contrast that one camera has shown. One thread at a time.
class TextureWatch {
 public:
  // Returns the contrast of `frame`, nullopt as FineContrast. Starts again with another camera than
  // the last frame's.
  std::optional<TextureContrast> Look(const Frame& frame,
                                      const Camera& camera,
                                      std::span<const DiffuseSample> samples);

 private:
  std::optional<Camera> camera_;
  double most_ = 0.0;
};

}  // namespace pleinair
