#include "apps/run_description.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "session/session_choices.h"

namespace pleinair {
namespace {

std::string DescribeDaylight(const RunCommandOptions& options, const SequenceSite& site) {
  if (DaylightOf(options, site) == Daylight::kGather) return "with the rest";
  const DirectDaylightOptions& direct = options.pipeline.object_light.direct_daylight;
  return fmt::format("by {} samples a shape of the sky, shadow maps of {} px",
                     direct.sampling.samples,
                     direct.shadows.map_size_px);
}

// What the frames are read as: one without the preferred kind has the other.
std::string DescribeFrames(FrameKind preferred, const Sequence& sequence) {
  bool any_linear = preferred == FrameKind::kLinear && sequence.frames.empty();
  bool any_8_bit = preferred == FrameKind::kLdr && sequence.frames.empty();
  for (const FrameEntry& frame : sequence.frames) {
    (IsPlayedLinear(frame, preferred) ? any_linear : any_8_bit) = true;
  }
  return any_linear && any_8_bit ? "linear and 8-bit" : any_linear ? "linear" : "8-bit";
}

std::string HowSunIsKnown(const FrameLight& light_of_frame) {
  const LightingEstimate& estimate = light_of_frame.estimate;
  if (!LightIsKnown(estimate.lighting)) {
    if (estimate.sun_elsewhere_enu) return " (hardly known: the sky's picture has it elsewhere)";
    return std::string(
               " (hardly known: the picture shows neither sun nor shade; earlier light and "
               "weather answer") +
           (light_of_frame.is_drawn_without_sun ? "; drawn without a sun)" : ")");
  }
  if (estimate.sun_observable) return {};
  const DirectionalLight& light = estimate.lighting.sun;
  if (light.direction_enu.z < -std::sin(light.angular_radius_rad)) {
    return light.direction_enu == kNoSunDirectionEnu ? " (no sun)" : " (sun below the horizon)";
  }
  const MeanIrradiance sun = MeanSunIrradiance(estimate.lighting);
  if (!(sun.stddev > 0.0 && sun.stddev < sun.mean)) return " (sun not observable in this picture)";
  return fmt::format(" (sun not observable in this picture; otherwise known to {:.0f} %)",
                     100.0 * sun.stddev / sun.mean);
}

std::string DoneOf(const RunReport& report) {
  return fmt::format(
      "{} of {} frames done", report.totals.done, report.totals.done + report.totals.failed);
}

}  // namespace

std::vector<std::string> DescribeSettings(const RunCommandOptions& options,
                                          const LoadedSequence& loaded,
                                          std::optional<std::size_t> frames,
                                          const GlDescription& gl) {
  const CameraIntrinsics& camera = loaded.sequence.intrinsics;
  std::vector<std::string> settings = {
      fmt::format("{}{}x{}",
                  frames ? fmt::format("{} frames, ", *frames) : std::string(),
                  camera.width_px,
                  camera.height_px),
      fmt::format(
          "frames {}, {} samples, seed {}, bounces {}, object light by {}, direct daylight {}, "
          "light {}",
          DescribeFrames(options.frames, loaded.sequence),
          options.light.samples,
          options.light.seed,
          options.prepare.bounces == kAllBounces ? "all" : std::to_string(options.prepare.bounces),
          options.pipeline.object_light.route == ObjectLight::kGather ? "rays at vertices"
          : options.pipeline.object_light.route == ObjectLight::kSingleProbe
              ? "rays at a single probe"
          : options.pipeline.object_light.route == ObjectLight::kVolume ? "folded probes"
                                                                        : "probes from the map",
          DescribeDaylight(options, loaded.site),
          options.pipeline.filter ? "filtered over time" : "of each frame by itself"),
      fmt::format("OpenGL: {} ({})", gl.renderer, gl.version)};
  if (loaded.board) {
    settings.push_back("camera poses from the markers of " + options.markers.string());
  }
  if (!options.poses.empty()) {
    settings.push_back("camera poses from " + options.poses.string());
  }
  return settings;
}

void LogLight(const FinishedFrame& finished, std::optional<std::size_t> of_frames) {
  if (!finished.step.result) return;
  const LightingEstimate& estimate = finished.step.result->estimate;
  const glm::dvec3 sun = estimate.lighting.sun.irradiance_rgb;
  const glm::dvec3 sky = estimate.lighting.SkyIrradianceRgb();
  spdlog::info("frame {}{}: sun {:.4g}, sky {:.4g}{}",
               finished.step.frame->index,
               of_frames ? fmt::format(" ({} of {})", finished.step.frame->index + 1, *of_frames)
                         : std::string(),
               (sun.x + sun.y + sun.z) / 3.0,
               (sky.x + sky.y + sky.z) / 3.0,
               HowSunIsKnown(*finished.step.result));
}

std::string TitleOf(const Sequence& sequence) { return "pleinair: " + sequence.NameOrFolder(); }

std::string StoppedAt(const FrameError& error) {
  return fmt::format("stopped at frame {}, as asked: {}", error.index, error.reason);
}

std::string InterruptedAfter(std::int64_t frames, std::optional<std::size_t> of_frames) {
  return fmt::format("interrupted after {}{} frame{}",
                     frames,
                     of_frames ? fmt::format(" of {}", *of_frames) : std::string(),
                     of_frames.value_or(static_cast<std::size_t>(frames)) == 1 ? "" : "s");
}

void SayWhereTheReportIs(const RunCommandOptions& options, const RunReport& report) {
  spdlog::info("{}; report: {}", DoneOf(report), (options.out / "report.html").string());
}

void SayHowItEnded(const RunCommandOptions& options,
                   const RunReport& report,
                   const Sequence& sequence) {
  if (report.totals.done > 0) {
    SayWhereTheReportIs(options, report);
    return;
  }
  spdlog::info("{}", DoneOf(report));
  throw std::runtime_error(
      report.totals.failed == 0
          ? (options.input.empty() ? sequence.folder.string() : options.input) +
                ": no frame was composited"
          : fmt::format("all frames of {} failed; {}",
                        options.input.empty() ? sequence.folder.string() : options.input,
                        report.totals.first_failure));
}

}  // namespace pleinair
