#include "estimation/given_lighting_source.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include <glm/common.hpp>

#include "scene/image_io.h"
#include "sunmodel/sky_shapes.h"
#include "sunmodel/time_text.h"

namespace pleinair {
namespace {

bool IsIrradiance(const glm::dvec3& value) {
  for (int c = 0; c < 3; ++c) {
    if (!(value[c] >= 0.0) || !std::isfinite(value[c])) return false;
  }
  return true;
}

std::optional<SkyShapeKind> KindOf(const std::string& name) {
  for (const SkyShapeKind kind : kAllSkyShapeKinds) {
    if (NameOf(kind) == name) return kind;
  }
  return std::nullopt;
}

// In the order of an estimate's shapes. Sums of their light then round as the estimate's own do.
std::vector<SkyShapeKind> KindsOf(const std::map<std::string, glm::dvec3>& sky_shares) {
  std::vector<SkyShapeKind> kinds;
  for (const SkyShapeKind kind : kAllSkyShapeKinds) {
    if (sky_shares.contains(std::string(NameOf(kind)))) kinds.push_back(kind);
  }
  return kinds;
}

std::string KnownShapes() {
  std::string names;
  for (const SkyShapeKind kind : kAllSkyShapeKinds) {
    names += (names.empty() ? "" : ", ") + std::string(NameOf(kind));
  }
  return names;
}

// Keeps each channel's shares; a channel that has none gets equal ones.
void ScaleTo(const glm::dvec3& sky_irradiance_rgb, Lighting& lighting) {
  const glm::dvec3 sum = lighting.SkyIrradianceRgb();
  const auto shapes = static_cast<double>(lighting.sky.size());
  for (SkyComponent& component : lighting.sky) {
    for (int c = 0; c < 3; ++c) {
      component.irradiance_rgb[c] =
          sum[c] > 0.0 ? component.irradiance_rgb[c] * sky_irradiance_rgb[c] / sum[c]
                       : sky_irradiance_rgb[c] / shapes;
    }
  }
}

class GivenLightingSource final : public LightingSource {
 public:
  GivenLightingSource(std::map<int, GivenLight> by_frame,
                      std::unique_ptr<LightingSource> shape_source,
                      double aerosol_optical_depth_500nm)
      : by_frame_(std::move(by_frame)),
        shape_source_(std::move(shape_source)),
        aerosol_optical_depth_500nm_(aerosol_optical_depth_500nm) {}

  tl::expected<SkyBasis, LightingFailure> BasisFor(const Frame& frame,
                                                   const SunState& sun) override {
    const auto found = by_frame_.find(frame.index);
    if (found == by_frame_.end()) {
      return tl::unexpected(LightingFailure{"the given lighting has no line for this frame"});
    }
    const GivenLight& light = found->second;
    if (std::string fault = FaultOfTime(light.time, frame.time); !fault.empty()) {
      return tl::unexpected(LightingFailure{"the given lighting is not of this frame: " + fault});
    }
    if (light.sky_image) return ImageBasis(*light.sky_image);
    if (!light.sky_shares.empty()) return SharesBasis(light, sun);
    return shape_source_->BasisFor(frame, sun);
  }

  tl::expected<LightingEstimate, LightingFailure> Estimate(
      const LightingObservation& observation) override {
    const GivenLight& light = by_frame_.at(observation.frame.index);
    LightingEstimate estimate;
    if (!light.sky_image && light.sky_shares.empty()) {
      LightingObservation held = observation;
      held.held = HeldIrradiance{light.sun_irradiance_rgb, light.sky_irradiance_rgb};
      auto fitted = shape_source_->Estimate(held);
      if (!fitted) return fitted;
      estimate = std::move(*fitted);
      ScaleTo(light.sky_irradiance_rgb, estimate.lighting);
      // Those of the fit are of what it was held to.
      estimate.lighting.covariance.clear();
    } else if (light.sky_image) {
      estimate.lighting.sky.push_back({basis_.front()->Name(), light.sky_irradiance_rgb});
    } else {
      for (const SkyShapeKind kind : KindsOf(light.sky_shares)) {
        const std::string name(NameOf(kind));
        estimate.lighting.sky.push_back(
            {name, light.sky_irradiance_rgb * light.sky_shares.at(name)});
      }
      ScaleTo(light.sky_irradiance_rgb, estimate.lighting);
    }
    estimate.lighting.time = observation.frame.time;
    estimate.lighting.sun = {observation.sun.direction_enu,
                             light.sun_irradiance_rgb,
                             observation.sun.angular_radius_rad};
    estimate.sun_observable = light.sun_observable;
    return estimate;
  }

 private:
  std::map<int, GivenLight> by_frame_;
  std::unique_ptr<LightingSource> shape_source_;
  double aerosol_optical_depth_500nm_;
  std::vector<std::shared_ptr<const SkyShape>> basis_;
  // The key of basis_.
  std::filesystem::path image_;
  std::vector<SkyShapeKind> kinds_;
  glm::dvec3 sun_enu_{0.0};

  tl::expected<SkyBasis, LightingFailure> ImageBasis(const std::filesystem::path& file) {
    if (file == image_) return SkyBasis(basis_);
    try {
      basis_ = {MakeImageSkyShape("image", ReadRadianceImage(file))};
    } catch (const std::exception& error) {
      return tl::unexpected(LightingFailure{error.what()});
    }
    image_ = file;
    kinds_.clear();
    return SkyBasis(basis_);
  }

  tl::expected<SkyBasis, LightingFailure> SharesBasis(const GivenLight& light,
                                                      const SunState& sun) {
    std::vector<SkyShapeKind> kinds = KindsOf(light.sky_shares);
    const bool same_kinds = kinds == kinds_;
    if (same_kinds && sun.direction_enu == sun_enu_) return SkyBasis(basis_);
    basis_.resize(kinds.size());
    for (std::size_t k = 0; k < kinds.size(); ++k) {
      if (!same_kinds || TurnsWithTheSun(kinds[k])) {
        basis_[k] = MakeSkyShape(kinds[k], sun.direction_enu, aerosol_optical_depth_500nm_);
      }
    }
    kinds_ = std::move(kinds);
    sun_enu_ = sun.direction_enu;
    image_.clear();
    return SkyBasis(basis_);
  }
};

}  // namespace

void GivenLight::Validate() const {
  if (!IsIrradiance(sun_irradiance_rgb)) {
    throw std::invalid_argument("sun_irradiance_rgb: expected three numbers not below 0");
  }
  if (!IsIrradiance(sky_irradiance_rgb)) {
    throw std::invalid_argument("sky_irradiance_rgb: expected three numbers not below 0");
  }
  if (sky_shares.empty()) return;
  if (sky_image) {
    throw std::invalid_argument("sky_image: expected either it or sky_shape, found both");
  }
  glm::dvec3 sum(0.0);
  for (const auto& [name, share] : sky_shares) {
    if (!KindOf(name)) {
      throw std::invalid_argument("sky_shape: " + name + ": expected one of " + KnownShapes());
    }
    if (!IsIrradiance(share)) {
      throw std::invalid_argument("sky_shape: " + name + ": expected three shares not below 0");
    }
    sum += share;
  }
  for (int c = 0; c < 3; ++c) {
    // A sky without light has no shares to add up.
    if (std::abs(sum[c] - 1.0) <= 0.01 || (sum[c] == 0.0 && sky_irradiance_rgb[c] == 0.0)) continue;
    throw std::invalid_argument("sky_shape: expected shares that add up to 1 in each channel");
  }
}

std::unique_ptr<LightingSource> MakeGivenLightingSource(
    std::map<int, GivenLight> by_frame,
    std::unique_ptr<LightingSource> shape_source,
    double aerosol_optical_depth_500nm) {
  for (const auto& [frame, light] : by_frame) light.Validate();
  return std::make_unique<GivenLightingSource>(
      std::move(by_frame), std::move(shape_source), aerosol_optical_depth_500nm);
}

}  // namespace pleinair
