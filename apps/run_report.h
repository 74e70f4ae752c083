// report.html of a run: one file that needs nothing else.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/frame_pipeline.h"
#include "scene/image.h"

namespace pleinair {

// A picture ready to be embedded.
struct ReportPicture {
  std::string jpeg;
};
ReportPicture MakeReportPicture(const Rgb8Image& image);

// How far apart the report shows composite and truth.
inline constexpr int kDifferenceGain = 4;

struct ReportFrame {
  int index = 0;
  UtcTime time{};
  std::string error;  // Empty when the frame was done; the rest is empty otherwise.
  ReportPicture input;
  ReportPicture composite;
  std::optional<ReportPicture> truth;
  std::optional<ReportPicture> difference;  // Composite less truth, kDifferenceGain times.
  Lighting lighting;
  LightingEstimate estimate;  // Its lighting is the one above.
  StageTimes timing_ms;
  EffectPlan plan;
  std::optional<glm::dvec3> true_sun_irradiance_rgb;
  std::optional<glm::dvec3> true_sky_irradiance_rgb;
};

struct RunReport {
  std::string title;
  std::vector<std::string> settings;  // One a line.
  std::vector<std::string> notes;     // What was assumed, repaired, left out.
  std::vector<ReportFrame> frames;
};

// Writes the file completely or not at all. Throws std::runtime_error naming the file.
void WriteRunReport(const std::filesystem::path& file, const RunReport& report);

}  // namespace pleinair
