#include "pipeline/sun_check.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/geometric.hpp>

#include "scene/angle_between.h"
#include "sunmodel/angles.h"
#include "sunmodel/north.h"

namespace pleinair {
namespace {

constexpr double kMovedRad = RadFromDeg(10.0);
constexpr double kShareChanged = 1.0 / 3.0;
constexpr double kWarnAgainRad = RadFromDeg(5.0);
constexpr double kLeastTurnRad = RadFromDeg(3.0);
constexpr double kSurelyTurnedSigmas = 4.0;

// The sun's share of the light on level ground.
double SunShare(const Lighting& lighting) {
  const auto sum = [](const glm::dvec3& rgb) { return rgb.x + rgb.y + rgb.z; };
  const double sun = sum(lighting.sun.irradiance_rgb) * std::max(lighting.sun.direction_enu.z, 0.0);
  const double all = sun + sum(lighting.SkyIrradianceRgb());
  return all > 0.0 ? sun / all : 0.0;
}

}  // namespace

SunCheck::SunCheck(Mesh mesh, std::span<const std::string> diffuse_regions)
    : finder_(std::move(mesh), diffuse_regions) {}

bool SunCheck::IsDue(const Lighting& lighting) {
  ++calls_;
  if (looks_ >= kMostLooks) return false;
  const bool power_of_two = (calls_ & (calls_ - 1)) == 0;
  return power_of_two || !last_look_ ||
         AngleBetweenRad(lighting.sun.direction_enu, last_look_->sun_enu) >= kMovedRad ||
         std::abs(SunShare(lighting) - last_look_->sun_share) >= kShareChanged;
}

std::optional<SunContradiction> SunCheck::Look(const Frame& frame, const Lighting& lighting) {
  return Look(frame, lighting, {})->contradiction;
}

std::optional<SunLook> SunCheck::Look(const Frame& frame,
                                      const Lighting& lighting,
                                      const std::stop_token& stop) {
  const glm::dvec3& stated = lighting.sun.direction_enu;
  const std::optional<ShownSun> found = finder_.ShownBy(frame, stated, stop);
  if (!found) return std::nullopt;
  ShownSun shown = *found;
  ++looks_;
  last_look_ = {stated, SunShare(lighting)};
  if (!shown.contradicts && shown.near_stated.determined) {
    // Each by itself may be too unsure, where all of them agree.
    const double weight = 1.0 / (shown.near_stated.stddev_rad * shown.near_stated.stddev_rad);
    const double offset_rad = shown.near_stated.azimuth_offset_rad;
    information_ += weight;
    weighted_offset_rad_ += weight * offset_rad;
    weighted_square_ += weight * offset_rad * offset_rad;
    ++turns_;
    const double mean_rad = weighted_offset_rad_ / information_;
    const double chi_squared = weighted_square_ - information_ * mean_rad * mean_rad;
    const double disagreement =
        turns_ > 1 ? std::sqrt(std::max(1.0, chi_squared / (turns_ - 1))) : 1.0;
    const double stddev_rad = disagreement / std::sqrt(information_);
    shown.contradicts =
        std::abs(mean_rad) >= std::max(kLeastTurnRad, kSurelyTurnedSigmas * stddev_rad);
    shown.direction_enu = TurnedClockwise(stated, mean_rad);
    shown.stddev_rad = stddev_rad * std::hypot(stated.x, stated.y);
  }
  if (!shown.contradicts) return SunLook{};
  const double angle_rad = AngleBetweenRad(shown.direction_enu, stated);
  if (warned_of_rad_ && std::abs(angle_rad - *warned_of_rad_) < kWarnAgainRad) return SunLook{};
  warned_of_rad_ = angle_rad;
  return SunLook{
      SunContradiction{frame.index, stated, shown.direction_enu, angle_rad, shown.stddev_rad}};
}

}  // namespace pleinair
