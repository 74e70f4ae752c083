// report.html of a run: one file that needs nothing else.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "apps/set_aside.h"
#include "apps/time_statistics.h"
#include "datasets/event.h"
#include "pipeline/frame_pipeline.h"
#include "scene/image.h"

namespace pleinair {

// How far apart the report shows composite and truth.
inline constexpr int kDifferenceGain = 4;

struct ReportFrame {
  int index = 0;
  UtcTime time{};
  std::string error;  // Empty when the frame was done; the rest is empty otherwise.
  // Places from RunReport::AddPicture; none: a gap.
  std::optional<SetAside::Place> input;
  std::optional<SetAside::Place> composite;
  std::optional<SetAside::Place> truth;
  std::optional<SetAside::Place> difference;  // Composite less truth, kDifferenceGain times.
  Lighting lighting;
  LightingEstimate estimate;          // Its lighting is the one above.
  bool is_drawn_without_sun = false;  // FrameLight's.
  StageTimes timing_ms;
  std::optional<double> latency_ms;  // None: not a live frame.
  EffectPlan plan;
  std::optional<glm::dvec3> true_sun_irradiance_rgb;
  std::optional<glm::dvec3> true_sky_irradiance_rgb;
};

// A frame's light for the charts: mean over RGB, and its deviation; NaN where the frame failed.
struct ReportLight {
  UtcTime time{};
  double sun = 0.0;
  double sun_stddev = 0.0;
  double sky = 0.0;
  double sky_stddev = 0.0;
};

inline constexpr std::size_t kStageCount = 8;

// What all frames add up to.
struct ReportTotals {
  std::int64_t done = 0;
  std::int64_t failed = 0;
  std::string first_failure;
  std::array<TimeStatistics, kStageCount> stages;  // In the order of StageTimes' members.
  TimeStatistics latency;  // From a live frame's timestamp to its composite.
  struct OfEffect {
    std::array<std::int64_t, 4> frames{};  // By EffectFate.
    double largest_left_out_code_values = 0.0;
  };
  std::map<Effect, OfEffect> effects;
  double largest_left_out_code_values = 0.0;
  double largest_left_out_rms_code_values = 0.0;
  double saved_ms = 0.0;
  double all_ms = 0.0;
  std::int64_t beyond_budget = 0;
};

// A run's frames in bounded memory: of a long run every second, fourth ... frame is shown, evenly
// over its length; totals are of all.
class RunReport {
 public:
  // The pictures are set aside in `folder`, as SetAside.
  explicit RunReport(const std::filesystem::path& folder) : pictures_(folder) {}

  std::string title;
  std::vector<std::string> settings;  // One a line.
  std::vector<std::string> notes;     // What was assumed, repaired, left out.
  std::vector<Event> events;          // Events of a live run; the first ones, where there are many.
  std::int64_t events_left_out = 0;
  std::vector<ReportFrame> frames;  // Frames that are shown.
  std::vector<ReportLight> light;
  ReportTotals totals;

  // Whether the next frame is one that is shown: its pictures are not needed otherwise.
  bool ShowsNext() const { return added_ % stride_ == 0; }
  // For the frame that is added next; once all are added, for any.
  SetAside::Place AddPicture(const Rgb8Image& image);
  std::string Jpeg(const SetAside::Place& picture) const { return pictures_.Read(picture); }
  // Where the disk is nearly full: what was set aside in it is then in memory.
  bool PicturesAreInMemory() const { return pictures_.IsInMemory(); }
  // Before the report is written: as SetAside.
  void LeaveRoom() { pictures_.LeaveRoom(); }
  void LeavePicturesOut();
  void Add(ReportFrame frame);
  void AddEvent(Event event);

 private:
  void KeepEverySecondFrame();

  SetAside pictures_;
  std::int64_t added_ = 0;
  std::int64_t stride_ = 1;
  std::int64_t light_stride_ = 1;
};

// Writes the file completely or not at all. Throws std::runtime_error naming the file.
void WriteRunReport(const std::filesystem::path& file, const RunReport& report);

}  // namespace pleinair
