// Frames, wherever they come from: recordings now, cameras later.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>
#include <tl/expected.hpp>

#include "calib/camera_noise.h"
#include "calib/response.h"  // kClippedFromCode, kNoiseFloorUpToCode
#include "datasets/sequence.h"
#include "scene/camera.h"
#include "scene/image.h"
#include "scene/image_io.h"
#include "scene/lighting.h"
#include "scene/utc_time.h"
#include "scene/weather.h"

namespace pleinair {

// Values of Frame::unusable; 0 is usable.
inline constexpr std::uint8_t kUnusable = 1;
// At the noise floor by itself. A mean over such pixels and others can be well above it, and would
// be too bright without them.
inline constexpr std::uint8_t kNearBlack = 2;
// Red, green or blue is clipped: its true value is at least the pixel's. The others are sound.
inline constexpr std::uint8_t kClipped[3] = {4, 8, 16};

struct Frame {
  int index = 0;  // 0-based, into the sequence's frames.
  UtcTime time{};
  Camera camera;
  std::optional<glm::dvec3>
      sun_direction_enu;  // Where the source knows better than place and time.

  std::optional<Weather> weather;  // As a person saw it, or a survey without a sun; none: unknown.

  // Scene-linear, in `units`. A linear frame's defects are kept.
  RgbImage radiance;
  ImageDefects defects;
  LightUnits units = LightUnits::kAbsolute;
  // Not 0 where a channel is clipped (kClipped), at the noise floor (kNearBlack) or not finite, or
  // outside the diffuse mask of a sequence whose mask is over its first frame (frames of that
  // camera): not to be measured from as it is.
  Gray8Image unusable;
  Gray8Image clipped;  // 1 where a channel is clipped: its true value is at least that.
  // The camera's own code values, where the frame came as 8 bit: what stays untouched in the
  // output.
  std::optional<Rgb8Image> codes;
  std::optional<double> exposure;  // Radiance to [0, 1]; see sequence_format.
  // Of the signal in [0, 1], radiance times exposure (1 where that is unknown). None where the
  // camera's noise is nothing beside other errors: linear frames.
  std::shared_ptr<const SignalNoise> noise;
  std::vector<SamplePolygon> sample_polygons;
  // The sky camera's picture where the frame has one: scene-linear, as MakeFisheyeSetup's camera
  // sees it, in the room camera's colours where the calibration ties them; defects are kept.
  std::optional<RgbImage> fisheye_radiance;
};

struct FrameError {
  int index = 0;
  UtcTime time{};
  std::string reason;  // One line: file, and what was expected.
};

// Frames in order; a bad one is an error in its place and the next call goes on.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  // None at the end.
  virtual std::optional<tl::expected<Frame, FrameError>> Next() = 0;
  // Frames that Next() will give in all; none where that is not known (a camera).
  virtual std::optional<int> Count() const = 0;
};

enum class FrameKind { kLinear, kLdr };

// Plays a recorded sequence. `preferred` decides where a frame has both kinds; a frame with one
// kind plays that one. The sequence is copied.
//
// Linear frames are clipped nowhere, and absolute. 8-bit ones give `exposure`-divided light:
// relative where the exposure is from the camera's metadata, and light in [0, 1], relative per
// frame, where it is unknown. `noise` is that of the 8-bit frames' camera. Fish-eye pictures are
// EXR or HDR. A file that is missing, truncated, empty, no file, of another size than its camera's,
// or outside the sequence's folder is that frame's error alone, and so is a linear frame or
// fish-eye picture without a finite pixel. Throws  std::runtime_error where the sequence's
// response, fish-eye calibration or first frame's
//         mask cannot be read; std::invalid_argument for impossible noise.
std::unique_ptr<FrameSource> MakeRecordedFrameSource(const Sequence& sequence,
                                                     FrameKind preferred,
                                                     const CameraNoise& noise = {});

}  // namespace pleinair
