// Measures in one fish-eye picture of the sky the sun's disc, and the sky without it (grosch-2007,
// section 5.1). Unlike there the disc is removed first: averaged into a region it would light the
// wrong places.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "calib/fisheye_camera.h"
#include "calib/fisheye_lens.h"
#include "estimation/region_averages.h"
#include "scene/image.h"
#include "scene/sky_regions.h"
#include "scene/sky_shape.h"

namespace pleinair {

// The disc's light above the sky around it, with what the lens spreads of it.
struct SunDiscReading {
  glm::dvec3 irradiance_rgb{0.0};  // Normal to the beam.
  // From the unevenness of the sky around the disc, and of the glare. Without meaning where
  // clipped.
  glm::dvec3 stddev_rgb{0.0};
  // The picture's brightest value covers more than a sun's disc, or the sky there is level: the
  // irradiance is a lower bound.
  bool clipped = false;
  // Where the picture shows the sun that was measured, if not where it was looked for: the camera's
  // orientation or lens, or the sun's direction, is wrong.
  std::optional<glm::dvec3> elsewhere_enu;
};

// How finely a picture's sky is kept as a shape.
enum class SkyDetail {
  kPicture,  // Pixel by pixel.
  kRegions,  // One radiance for each region, as in grosch-2007.
};

// Reads pictures of one camera, with a common set-up. Radiances in the picture's unit, irradiances
// in that unit times sr. One thread at a time.
class FisheyeSky {
 public:
  // Throws std::invalid_argument where the camera sees no part of the upper hemisphere, and as
  // MakeFisheyePixelTable does.
  FisheyeSky(const FisheyeCamera& camera,
             const SkyRegions& regions,
             SkyDetail detail = SkyDetail::kPicture);

  // The disc is looked for within 2.5 deg of `sun_direction_enu`; a sun below the horizon has none.
  // Where there is none, a disc anywhere that holds 0.7 of the sky's light is the sun, too. So is
  // as much light within 10 deg of the direction, spread by water on the dome, if a disc there has
  // less than half of it. Pixels that are NaN or below 0 are left out; infinite ones are clipped.
  // Throws std::invalid_argument for a picture of another size than the camera's.
  void Read(const RgbImage& radiance,
            const glm::dvec3& sun_direction_enu,
            double sun_angular_radius_rad);

  const SunDiscReading& Sun() const { return sun_; }
  // Mean radiance of each region over solid angle, without the disc. A region that the picture does
  // not show has the radiance of the nearest one above it; in the highest band, the mean of all.
  std::span<const glm::dvec3> RegionRadiance() const { return region_averages_.Radiance(); }
  // The sky without the disc: its shape, and its irradiance on an unoccluded horizontal plane.
  // Directions that the picture does not show have their region's radiance. The shape is the same
  // object while pictures show the same sky.
  std::shared_ptr<const SkyShape> Shape() const { return shape_; }
  glm::dvec3 SkyIrradianceRgb() const { return sky_irradiance_rgb_; }

 private:
  SkyDetail detail_;
  FisheyeLens lens_;
  glm::dmat3 camera_from_world_;
  FisheyePixelTable table_;
  RegionAverages region_averages_;
  // For each cell of SkyTable the nearest pixel; kNone where the picture does not show it.
  static constexpr std::uint32_t kNone = 0xffffffffu;
  std::vector<std::uint32_t> pixel_of_cell_;
  std::vector<std::uint32_t> region_of_cell_;

  SunDiscReading sun_;
  std::vector<glm::vec3> sky_table_;
  std::shared_ptr<const SkyShape> shape_;
  glm::dvec3 sky_irradiance_rgb_{0.0};

  struct PixelWindow {
    int left;
    int top;
    int right;
    int bottom;
  };
  // Contains every pixel within `radius_rad` of a direction.
  PixelWindow WindowAround(const glm::dvec3& direction_enu, double radius_rad) const;

  // Pixels around the disc, and the radiance of the sky there without it.
  struct DiscArea {
    std::vector<std::uint32_t> pixels;
    glm::vec3 background{0.0f};
    float level_luminance = 0.0f;  // Without a disc: of a level top there; 0 without one.
  };
  // Where the sun should be, or elsewhere.
  DiscArea FindDisc(const RgbImage& radiance,
                    const glm::dvec3& sun_direction_enu,
                    double sun_angular_radius_rad);
  DiscArea ReadDisc(const RgbImage& radiance,
                    const glm::dvec3& sun_direction_enu,
                    double sun_angular_radius_rad);
  // Counts light near a disc that outshines the sky as the disc's.
  void TakeGlare(const RgbImage& radiance, const glm::dvec3& centre_enu, DiscArea& disc);
  // Of the upper hemisphere on a level plane, the sum of the channels.
  double HorizontalLight(const RgbImage& radiance) const;
  // In the upper hemisphere; kNone in the dark.
  std::uint32_t BrightestPixel(const RgbImage& radiance) const;
  DiscArea FindDiscElsewhere(const RgbImage& radiance,
                             std::uint32_t brightest,
                             double sun_angular_radius_rad);
  // Where it is more than the disc that was read.
  DiscArea ReadSpreadSun(const RgbImage& radiance, const glm::dvec3& sun_direction_enu);
  void ReadSky(const RgbImage& radiance, const DiscArea& disc);
};

}  // namespace pleinair
