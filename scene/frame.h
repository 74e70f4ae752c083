// One picture of the camera, with what is known of it.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "scene/camera.h"
#include "scene/image.h"
#include "scene/image_io.h"
#include "scene/judged_sun.h"
#include "scene/lighting.h"
#include "scene/utc_time.h"
#include "scene/weather.h"

namespace pleinair {

class SignalNoise;  // calib/camera_noise.h

// A part of the picture that shows one diffuse surface.
struct SamplePolygon {
  std::string material;
  std::string group;
  JudgedSun sun = JudgedSun::kUnknown;
  std::vector<glm::dvec2> polygon_px;
};

// Values of Frame::unusable; 0 is usable.
inline constexpr std::uint8_t kUnusable = 1;
// The pixel is at the noise floor. A mean over such pixels and others can be well above it, and
// would be too bright without them.
inline constexpr std::uint8_t kNearBlack = 2;
// Red, green or blue is clipped: its true value is at least the pixel's. The others are sound.
inline constexpr std::uint8_t kClipped[3] = {4, 8, 16};

// A picture and its metadata. Images have the camera's size.
struct Frame {
  int index = 0;  // 0-based, into the sequence's frames.
  UtcTime time{};
  Camera camera;
  std::optional<glm::dvec3>
      sun_direction_enu;  // Where the source has a better value than place and time.

  // As judged by a person, or by a survey without a sun; none: unknown.
  std::optional<Weather> weather;

  // Scene-linear, in `units`. A linear frame's defects are kept.
  RgbImage radiance;
  ImageDefects defects;
  LightUnits units = LightUnits::kAbsolute;
  // Not 0 where a pixel must not be measured without care: a channel is clipped (kClipped), at the
  // noise floor (kNearBlack) or not finite. Also outside the diffuse mask, where the sequence's
  // mask is over its first frame (frames of that camera).
  Gray8Image unusable;
  Gray8Image clipped;  // 1 where a channel is clipped: its true value is at least that.
  // The camera's own code values, for 8-bit frames: pixels that nothing changes keep them in the
  // output.
  std::optional<Rgb8Image> codes;
  std::optional<double> exposure;    // Radiance to [0, 1]; see sequence_format.
  std::optional<double> exposure_s;  // How long the shutter was open. None: unknown.
  // Noise of the signal in [0, 1], radiance times exposure (1 where that is unknown). None where
  // the camera's noise is negligible: linear frames.
  std::shared_ptr<const SignalNoise> noise;
  std::vector<SamplePolygon> sample_polygons;
  // The sky camera's picture where the frame has one: scene-linear, as MakeFisheyeSetup's camera
  // sees it, in the room camera's colours where the calibration ties them; defects are kept.
  std::optional<RgbImage> fisheye_radiance;
};

// Why a frame could not be read.
struct FrameError {
  int index = 0;
  UtcTime time{};
  std::string reason;  // One line: file, and what was expected.
};

}  // namespace pleinair
