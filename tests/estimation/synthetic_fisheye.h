// A made-up fish-eye picture of a sky that brightens to the south, with or without a sun.
#pragma once

#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "calib/fisheye_camera.h"
#include "calib/fisheye_lens.h"
#include "scene/image.h"
#include "scene/lighting.h"

namespace pleinair::testing {

inline glm::dvec3 DirectionEnu(double azimuth_deg, double elevation_deg) {
  const double azimuth = azimuth_deg * std::numbers::pi / 180.0;
  const double elevation = elevation_deg * std::numbers::pi / 180.0;
  return {std::sin(azimuth) * std::cos(elevation),
          std::cos(azimuth) * std::cos(elevation),
          std::sin(elevation)};
}

// Looks straight up, north at the top, east at the right, the whole hemisphere in its circle.
inline FisheyeCamera SkyCamera(int side_px) {
  return {CentredFisheye(FisheyeModel::kEquidistant, std::numbers::pi, side_px, side_px),
          *FisheyeOrientationFromAxes({0.0, 0.0, 1.0}, {0.0, 1.0, 0.0}, {1.0, 0.0, 0.0})};
}

struct FisheyePicture {
  int side_px = 512;
  glm::dvec3 sun_direction_enu = DirectionEnu(160.0, 40.0);
  glm::dvec3 sun_radiance{1.2e7, 1.1e7, 0.9e7};
  double spread_px = 0.0;  // A lens's: a Gaussian's deviation.

  void PutSunAt(double azimuth_deg, double elevation_deg) {
    sun_direction_enu = DirectionEnu(azimuth_deg, elevation_deg);
  }
  glm::dvec3 Sky(const glm::dvec3& direction_enu) const {
    const double level = 30.0 - 15.0 * direction_enu.y + 8.0 * direction_enu.z;
    return level * glm::dvec3(0.8, 1.0, 1.4);
  }
};

inline RgbImage MakeFisheyePicture(const FisheyePicture& picture) {
  const FisheyeCamera camera = SkyCamera(picture.side_px);
  const FisheyeLens lens(camera.intrinsics);
  RgbImage image(picture.side_px, picture.side_px, glm::vec3(0.0f));
  const auto sun_px =
      lens.ProjectToPixel(glm::transpose(camera.world_from_camera) * picture.sun_direction_enu);
  const double disc_sr = std::numbers::pi * kMeanSunAngularRadiusRad * kMeanSunAngularRadiusRad;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const auto direction = lens.DirectionFromPixel({x, y});
      if (!direction) continue;
      image.At(x, y) = glm::vec3(picture.Sky(camera.world_from_camera * *direction));
      if (!sun_px || std::hypot(sun_px->x - x, sun_px->y - y) > 4.0 + 4.0 * picture.spread_px) {
        continue;
      }
      double share = 0.0;  // Of the pixel's solid angle that the disc covers.
      if (picture.spread_px > 0.0) {
        const double r = std::hypot(sun_px->x - x, sun_px->y - y) / picture.spread_px;
        share = disc_sr / lens.PixelSolidAngleSr({x, y}) * std::exp(-0.5 * r * r) /
                (2.0 * std::numbers::pi * picture.spread_px * picture.spread_px);
      } else {
        constexpr int kSide = 16;
        for (int i = 0; i < kSide * kSide; ++i) {
          const int row = i / kSide;
          const int column = i % kSide;
          const auto point = lens.DirectionFromPixel(
              {x + (column + 0.5) / kSide - 0.5, y + (row + 0.5) / kSide - 0.5});
          if (!point) continue;
          const double cosine =
              glm::dot(camera.world_from_camera * *point, picture.sun_direction_enu);
          if (cosine > std::cos(kMeanSunAngularRadiusRad)) share += 1.0 / (kSide * kSide);
        }
      }
      image.At(x, y) += glm::vec3(share * picture.sun_radiance);
    }
  }
  return image;
}

}  // namespace pleinair::testing
