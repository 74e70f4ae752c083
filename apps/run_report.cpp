#include "apps/run_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <stdexcept>

#include <fmt/format.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "apps/html_text.h"
#include "apps/svg_chart.h"
#include "apps/whole_text.h"
#include "pipeline/display_codes.h"
#include "sunmodel/time_text.h"

namespace pleinair {
namespace {

constexpr int kLargestPictureWidthPx = 480;
constexpr int kJpegQuality = 88;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

const char* const kStyle = R"css(
body { font: 15px/1.45 system-ui, sans-serif; margin: 2em auto; max-width: 1500px; padding: 0 1em; color: #222 }
h1 { font-size: 1.5em } h2 { font-size: 1.15em; margin-top: 2em }
table { border-collapse: collapse } td, th { padding: .15em .8em; text-align: right; border-bottom: 1px solid #ddd }
td:first-child, th:first-child { text-align: left }
.frame { display: grid; grid-template-columns: repeat(3, minmax(0, 1fr)); gap: .5em; margin: .4em 0 1.4em }
.frame p { grid-column: 1 / -1; margin: 0 } .frame img { width: 100%; display: block }
figure { margin: 0 } figcaption { color: #666; font-size: .85em } .bad { color: #a00 } svg { max-width: 100%; height: auto }
)css";

std::string Base64(const std::string& bytes) {
  static const char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = group << 8 | (i + k < bytes.size() ? static_cast<std::uint8_t>(bytes[i + k]) : 0u);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += i + k > bytes.size() ? '=' : kDigits[group >> (18 - 6 * k) & 63u];
    }
  }
  return text;
}

std::string Figure(const std::string& caption, const ReportPicture& picture) {
  return fmt::format(
      "<figure><img alt=\"{0}\" "
      "src=\"data:image/jpeg;base64,{1}\"><figcaption>{0}</figcaption></figure>\n",
      caption,
      Base64(picture.jpeg));
}

// Mean over RGB and its standard deviation from the covariance of the basis lights given.
struct MeanAndStddev {
  double mean = kNaN;
  double stddev = 0.0;
};

MeanAndStddev MeanOf(const Lighting& lighting, bool sun) {
  const glm::dvec3 rgb = sun ? lighting.sun.irradiance_rgb : lighting.SkyIrradianceRgb();
  MeanAndStddev result{(rgb.x + rgb.y + rgb.z) / 3.0, 0.0};
  const std::size_t side = 3 * (1 + lighting.sky.size());
  if (lighting.covariance.size() != side * side) return result;
  const std::size_t begin = sun ? 0 : 3;
  const std::size_t end = sun ? 3 : side;
  double variance = 0.0;
  for (std::size_t a = begin; a < end; ++a) {
    for (std::size_t b = begin; b < end; ++b) variance += lighting.covariance[a * side + b];
  }
  result.stddev = std::sqrt(std::max(0.0, variance)) / 3.0;
  return result;
}

std::string LightChart(const RunReport& report, bool sun) {
  ChartSeries estimated{"estimate ± σ", sun ? "#d07000" : "#2060c0", ChartSeries::Style::kBand, {}};
  ChartSeries truth{"truth", "#000000", ChartSeries::Style::kPoints, {}};
  const UtcTime start = report.frames.front().time;
  for (const ReportFrame& frame : report.frames) {
    const ChartValue minutes = ChartValue::Exact(
        std::chrono::duration<double, std::ratio<60>>(frame.time - start).count());
    const MeanAndStddev light = frame.error.empty() ? MeanOf(frame.lighting, sun) : MeanAndStddev{};
    estimated.points.push_back(
        {minutes, {light.mean, light.mean - light.stddev, light.mean + light.stddev}, ""});
    const auto& true_rgb = sun ? frame.true_sun_irradiance_rgb : frame.true_sky_irradiance_rgb;
    if (true_rgb) {
      truth.points.push_back(
          {minutes, ChartValue::Exact((true_rgb->x + true_rgb->y + true_rgb->z) / 3.0), ""});
    }
  }
  const Chart chart{sun ? "Sun: irradiance normal to the beam, mean of RGB"
                        : "Sky: horizontal irradiance, mean of RGB",
                    {"minutes since the first frame", ChartAxis::Scale::kFromZero},
                    {"W/m² per channel (or relative)", ChartAxis::Scale::kFromZero},
                    {std::move(estimated), std::move(truth)}};
  return ChartsForPage(std::span(&chart, 1));
}

std::string TimingTable(const RunReport& report) {
  struct Stage {
    const char* name;
    double StageTimes::*member;
  };
  static const Stage kStages[] = {{"read", &StageTimes::read},
                                  {"transport", &StageTimes::transport},
                                  {"estimate", &StageTimes::estimate},
                                  {"relight", &StageTimes::relight},
                                  {"probes", &StageTimes::probes},
                                  {"render", &StageTimes::render},
                                  {"readback", &StageTimes::readback},
                                  {"write", &StageTimes::write}};
  std::string html = "<table><tr><th>stage</th><th>median ms</th><th>largest ms</th></tr>\n";
  for (const Stage& stage : kStages) {
    std::vector<double> times;
    for (const ReportFrame& frame : report.frames) {
      if (frame.error.empty()) times.push_back(frame.timing_ms.*stage.member);
    }
    if (times.empty()) continue;
    std::sort(times.begin(), times.end());
    html += fmt::format("<tr><td>{}</td><td>{:.2f}</td><td>{:.2f}</td></tr>\n",
                        stage.name,
                        times[times.size() / 2],
                        times.back());
  }
  return html + "</table>\n";
}

// What is left out: by its bound, or, where that says no more than "all", as it usually is.
std::string InCodeValues(double bound, double rms) {
  if (bound < kWhiteCode) return fmt::format("{:.2f} code values at most", bound);
  return fmt::format("about {:.1f} code values, root mean square over the objects' pixels", rms);
}

// Effect by effect, over all frames.
std::string EffectTable(const RunReport& report) {
  double largest_left_out = 0.0;
  double largest_rms = 0.0;
  double saved_ms = 0.0;
  double all_ms = 0.0;
  int late = 0;
  for (const ReportFrame& frame : report.frames) {
    largest_left_out = std::max(largest_left_out, frame.plan.left_out_code_values);
    largest_rms = std::max(largest_rms, frame.plan.left_out_rms_code_values);
    saved_ms += frame.plan.SavedMs();
    all_ms += frame.plan.all_expected_ms;
    late += frame.plan.fits_budget ? 0 : 1;
  }
  std::string html =
      "<table><tr><th>effect</th><th>frames that simulate it</th><th>that keep the last one's</th>"
      "<th>that leave it out</th><th>largest bound left out, code values</th></tr>\n";
  for (const Effect effect : kAllEffects) {
    std::array<int, 4> frames{};
    double largest = 0.0;
    for (const ReportFrame& frame : report.frames) {
      if (!frame.error.empty()) continue;
      const PlannedEffect& planned = frame.plan.Of(effect);
      ++frames[static_cast<std::size_t>(planned.fate)];
      if (planned.fate == EffectFate::kLeftOut) {
        largest = std::max(largest, planned.bound_code_values);
      }
    }
    const auto count = [&](EffectFate fate) { return frames[static_cast<std::size_t>(fate)]; };
    if (count(EffectFate::kRun) + count(EffectFate::kKept) + count(EffectFate::kLeftOut) == 0) {
      continue;
    }
    html += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{:.2f}</td></tr>\n",
                        NameOf(effect),
                        count(EffectFate::kRun),
                        count(EffectFate::kKept),
                        count(EffectFate::kLeftOut),
                        largest);
  }
  html += fmt::format(
      "</table>\n<p>What a frame left out could change by {}, and saved {:.1f} of {:.1f} ms over "
      "all "
      "frames, as expected from what works took.{}</p>\n",
      InCodeValues(largest_left_out, largest_rms),
      saved_ms,
      all_ms,
      late > 0 ? fmt::format(" {} frames did not fit into the budget.", late) : std::string());
  return html;
}

// What a frame's plan left out, for the eye.
std::string LeftOut(const EffectPlan& plan) {
  std::string names;
  for (const PlannedEffect& effect : plan.effects) {
    if (effect.fate != EffectFate::kLeftOut) continue;
    names += fmt::format("{}{} ({})", names.empty() ? "" : ", ", NameOf(effect.effect), effect.why);
  }
  if (names.empty()) return {};
  return fmt::format("; left out: {}: {}, {:.1f} ms saved",
                     names,
                     InCodeValues(plan.left_out_code_values, plan.left_out_rms_code_values),
                     plan.SavedMs());
}

std::string List(const std::vector<std::string>& lines) {
  std::string html = "<ul>\n";
  for (const std::string& line : lines) html += "<li>" + EscapeHtml(line) + "</li>\n";
  return html + "</ul>\n";
}

std::string FrameSection(const ReportFrame& frame) {
  std::string html = "<div class=\"frame\">";
  if (!frame.error.empty()) {
    return html + fmt::format("<p class=\"bad\"><b>{}</b> {}: {}</p></div>\n",
                              frame.index,
                              FormatUtcTime(frame.time),
                              EscapeHtml(frame.error));
  }
  const glm::dvec3 sun = frame.lighting.sun.irradiance_rgb;
  const glm::dvec3 sky = frame.lighting.SkyIrradianceRgb();
  html += fmt::format(
      "<p><b>{}</b> {} &mdash; sun {:.4g} {:.4g} {:.4g}{}, sky {:.4g} {:.4g} {:.4g}; "
      "{} samples, {:.0f} % inliers, residual {:.1f} %{}{}</p>\n",
      frame.index,
      FormatUtcTime(frame.time),
      sun.x,
      sun.y,
      sun.z,
      frame.estimate.sun_observable ? "" : " (not observable)",
      sky.x,
      sky.y,
      sky.z,
      frame.estimate.samples_used,
      100.0 * frame.estimate.inlier_fraction,
      100.0 * frame.estimate.relative_residual,
      !LightIsKnown(frame.estimate.lighting) ? " (sun and sky hardly known)"
      : ModelMismatch(frame.estimate)        ? " (picture and model do not fit)"
                                             : "",
      LeftOut(frame.plan));
  html += Figure("input", frame.input) + Figure("composite", frame.composite);
  if (frame.truth) html += Figure("truth", *frame.truth);
  if (frame.difference) {
    html +=
        Figure(fmt::format("composite less truth, {} times", kDifferenceGain), *frame.difference);
  }
  return html + "</div>\n";
}

}  // namespace

ReportPicture MakeReportPicture(const Rgb8Image& image) {
  if (image.Empty()) return {};
  // OpenCV does not write through its input; the cast is for its constructor alone.
  const cv::Mat rgb(
      image.height, image.width, CV_8UC3, const_cast<glm::u8vec3*>(image.pixels.data()));
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  if (bgr.cols > kLargestPictureWidthPx) {
    const double scale = double(kLargestPictureWidthPx) / bgr.cols;
    cv::resize(bgr, bgr, cv::Size(), scale, scale, cv::INTER_AREA);
  }
  std::vector<std::uint8_t> jpeg;
  cv::imencode(".jpg", bgr, jpeg, {cv::IMWRITE_JPEG_QUALITY, kJpegQuality});
  return {std::string(jpeg.begin(), jpeg.end())};
}

void WriteRunReport(const std::filesystem::path& file, const RunReport& report) {
  std::string html = fmt::format(
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{0}</title>"
      "<style>{1}</style></head>\n<body><h1>{0}</h1>\n",
      EscapeHtml(report.title),
      kStyle);
  html += List(report.settings);
  if (!report.notes.empty()) html += "<h2>Notes</h2>\n" + List(report.notes);
  const bool any_done = std::any_of(report.frames.begin(),
                                    report.frames.end(),
                                    [](const ReportFrame& frame) { return frame.error.empty(); });
  if (any_done) {
    html += "<h2>Light over time</h2>\n" + LightChart(report, true) + "<br>\n" +
            LightChart(report, false) + "\n";
    html += "<h2>Time per stage</h2>\n" + TimingTable(report);
    html += "<h2>Effects</h2>\n" + EffectTable(report);
  }
  if (!report.frames.empty()) html += "<h2>Frames</h2>\n";
  for (const ReportFrame& frame : report.frames) html += FrameSection(frame);
  html += "</body></html>\n";

  WriteWholeText(file, html);
}

}  // namespace pleinair
