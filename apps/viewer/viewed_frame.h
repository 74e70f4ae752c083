// What the window asks for, and what it gets to show.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "apps/viewer/overlay.h"
#include "datasets/sequence.h"
#include "objects/direct_daylight.h"
#include "pipeline/effect.h"
#include "session/sequence_session.h"

namespace pleinair {

// The state that the window wants; each field's last value counts. A number that has changed asks
// for something once.
struct ViewRequest {
  bool is_playing = false;  // False: the last picture of a camera stays.
  bool loops = true;
  double frames_per_second = 10.0;  // For recorded frames.
  std::int64_t seeks = 0;
  int seek_frame = 0;

  std::vector<VirtualObjectEntry> objects;
  std::int64_t edits = 0;    // Changes of `objects`.
  bool is_dragging = false;  // Pictures come fast, and complete when it ends.
  // Light in steps is completed even while frames are played.
  bool wants_complete = false;

  EffectSettings effects;
  std::vector<std::string> settings;  // "name=value", after those of the command line.
  std::int64_t settings_changes = 0;

  double exposure_stops = 0.0;         // For the shown picture alone.
  std::optional<std::size_t> overlay;  // Into Overlays().
  bool wants_histogram = false;
  bool wants_environment = false;
  bool wants_probes = false;
  bool wants_daylight = false;
  bool wants_input = false;

  bool is_recording = false;  // A camera's pictures.
};

// Histogram of the camera's picture as shown: pixels a code value and channel.
struct PictureHistogram {
  std::array<std::array<int, 3>, 256> counts{};
  int largest = 0;  // The largest count of the codes between the ends.
  int pixels = 0;
};

// A white diffuse ball in the light at a place, seen from the side that the camera is on.
struct ShadedBall {
  glm::dvec3 centre_world_m{0.0};
  double radius_m = 0.1;
  Rgba8Image picture;
};

// Openings to the sky, and the far lights that are drawn through them.
struct ViewedDaylight {
  std::string note;  // What the samples are restricted to, in a line.
  std::vector<Window> windows;
  std::vector<DaylightSample> samples;  // For a unit of each shape of the sky.
};

struct ViewedFrame {
  std::int64_t number = 0;  // Counts all that were made: differs from frame to frame.
  ViewRequest request;      // That it answers, with the effects as they were asked of the session.
  SessionStep step;
  Rgb8Image shown;     // The composite; the camera's picture where that failed; else empty.
  Rgba8Image overlay;  // Empty: none.
  std::optional<Rgb8Image> input;  // The camera's picture, without objects.
  std::optional<PictureHistogram> histogram;
  std::optional<Rgb8Image> environment;  // Lat-long, with the sun.
  std::optional<RgbImage> sky;  // Where it has no named shape: see SequenceSession::SkyImageOf.
  std::vector<ShadedBall> balls;
  std::optional<ViewedDaylight> daylight;  // Where it comes by samples.
  double work_ms = 0.0;                    // From the frame at hand to all of the above.

  // Made while dragging: effects are left out for speed.
  bool IsQuick() const { return request.is_dragging; }
  // What a run of this frame by itself gives: with all effects, and not lit in steps.
  bool IsComplete() const { return !IsQuick() && !(Succeeded() && step.result->is_light_coarse); }
  bool Succeeded() const { return step.result.has_value(); }
  int Index() const { return Succeeded() ? step.frame->index : step.result.error().index; }
  UtcTime Time() const { return Succeeded() ? step.frame->time : step.result.error().time; }
};

// One frame's light, kept of all frames.
struct LightPoint {
  int frame = 0;
  UtcTime time{};
  glm::dvec3 sun_rgb{0.0};
  glm::dvec3 sky_rgb{0.0};
  glm::dvec3 sun_stddev_rgb{0.0};
  glm::dvec3 sky_stddev_rgb{0.0};
  bool has_stddev = false;
  bool failed = false;
};

}  // namespace pleinair
