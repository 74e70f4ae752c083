#include "estimation/exposure_change.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <optional>

#include <glm/geometric.hpp>

#include "estimation/internal/lit_limits.h"
#include "scene/upper_median.h"

namespace pleinair {
namespace {

using estimation_internal::kFullyLit;
using estimation_internal::kFullyShaded;
using estimation_internal::kLeastSunCosine;

constexpr int kPatchesAcross = 60;  // Number of columns of square patches in a picture.
constexpr int kPatchRadiusPx = 1;
constexpr std::size_t kLeastPatches = 20;
constexpr std::chrono::seconds kLongestGap{2};

// In logarithms of radiance. Medians of twenty patches of nine pixels agree to half a per cent by
// noise, and to some per cent of a change by the response curve's error. A cloud changes the ratio
// of sun and shade by as much as it changes either.
constexpr double kSmallestChange = 0.01;
constexpr double kLargestSplit = 0.02;
constexpr double kLargestSplitOfChange = 0.1;

}  // namespace

void ExposureWatch::ReadPatches(const Frame& frame, const SurfaceView& view) {
  const int step = std::max(2 * kPatchRadiusPx + 1, view.Width() / kPatchesAcross);
  patches_.clear();
  for (int y = step / 2; y + kPatchRadiusPx < view.Height(); y += step) {
    for (int x = step / 2; x + kPatchRadiusPx < view.Width(); x += step) {
      Patch& patch = patches_.emplace_back();
      patch.usable = true;
      glm::vec3 sum(0.0f);
      for (int dy = -kPatchRadiusPx; dy <= kPatchRadiusPx; ++dy) {
        for (int dx = -kPatchRadiusPx; dx <= kPatchRadiusPx; ++dx) {
          const std::size_t pixel = view.region.Index(x + dx, y + dy);
          patch.usable = patch.usable && frame.unusable.pixels[pixel] == 0;
          sum += frame.radiance.pixels[pixel];
        }
      }
      patch.radiance = sum;
      const std::size_t pixel = view.region.Index(x, y);
      const float visibility = view.sun_visibility.pixels[pixel];
      const bool faces_sun = glm::dot(view.normal_world.pixels[pixel],
                                      glm::vec3(view.sun_direction_enu)) >= kLeastSunCosine;
      if (view.region.pixels[pixel] == SurfaceView::kNoRegion) {
        // In a part of a view that may be anything.
        patch.lit = view.is_whole ? Lit::kSky : Lit::kMixed;
      } else if (visibility <= kFullyShaded) {
        patch.lit = Lit::kShade;
      } else if (visibility >= kFullyLit && faces_sun) {
        patch.lit = Lit::kSun;
      }
    }
  }
}

ExposureChange ExposureWatch::Compare(const Frame& frame, const SurfaceView& view) {
  last_.swap(patches_);
  ReadPatches(frame, view);
  const auto gap = frame.time > time_ ? frame.time - time_ : time_ - frame.time;
  const bool comparable =
      last_.size() == patches_.size() && frame.camera == camera_ && gap <= kLongestGap;
  camera_ = frame.camera;
  time_ = frame.time;
  if (!comparable) return {};

  // Logarithm of this picture over the last.
  const auto change_of = [&](Lit lit) -> std::optional<glm::dvec3> {
    for (std::vector<double>& ratios : ratios_) ratios.clear();
    for (std::size_t i = 0; i < patches_.size(); ++i) {
      if (patches_[i].lit != lit || last_[i].lit != lit) continue;
      if (!patches_[i].usable || !last_[i].usable) continue;
      for (int c = 0; c < 3; ++c) {
        const double ratio = double{patches_[i].radiance[c]} / double{last_[i].radiance[c]};
        if (ratio > 0.0 && std::isfinite(ratio)) {
          ratios_[static_cast<std::size_t>(c)].push_back(std::log(ratio));
        }
      }
    }
    glm::dvec3 change;
    for (int c = 0; c < 3; ++c) {
      std::vector<double>& ratios = ratios_[static_cast<std::size_t>(c)];
      if (ratios.size() < kLeastPatches) return std::nullopt;
      change[c] = UpperMedianInPlace(ratios);
    }
    return change;
  };
  std::optional<glm::dvec3> first = change_of(Lit::kSun);
  std::optional<glm::dvec3> second = change_of(Lit::kShade);
  if (!first) first = change_of(Lit::kSky);
  if (!second) second = change_of(Lit::kSky);
  if (!first || !second) return {};

  double change = 0.0;
  double split = 0.0;
  for (int c = 0; c < 3; ++c) {
    change = std::max({change, std::abs((*first)[c]), std::abs((*second)[c])});
    split = std::max(split, std::abs((*first)[c] - (*second)[c]));
  }
  const glm::dvec3 factor = glm::exp(0.5 * (*first + *second));
  if (change < kSmallestChange) return {ExposureChange::Kind::kNone, factor};
  if (split <= std::max(kLargestSplit, kLargestSplitOfChange * change)) {
    return {ExposureChange::Kind::kExposure, factor};
  }
  return {ExposureChange::Kind::kLight, glm::dvec3(1.0)};
}

}  // namespace pleinair
