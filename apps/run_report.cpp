#include "apps/run_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <stdexcept>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "apps/html_text.h"
#include "apps/svg_chart.h"
#include "pipeline/display_codes.h"
#include "scene/image_io.h"
#include "scene/whole_file.h"
#include "sunmodel/time_text.h"

namespace pleinair {
namespace {

constexpr int kLargestPictureWidthPx = 480;
constexpr int kJpegQuality = 88;
// A page of so many frames opens within seconds.
constexpr std::size_t kMostFrames = 400;
constexpr std::size_t kMostLights = 4000;
constexpr std::size_t kMostEvents = 1000;
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

std::string Figure(const std::string& caption, const std::string& jpeg) {
  return fmt::format(
      "<figure><img loading=\"lazy\" decoding=\"async\" alt=\"{0}\" "
      "src=\"data:image/jpeg;base64,{1}\"><figcaption>{0}</figcaption></figure>\n",
      caption,
      Base64(jpeg));
}

std::string LightChart(const RunReport& report, bool sun) {
  ChartSeries estimated{"estimate ± σ", sun ? "#d07000" : "#2060c0", ChartSeries::Style::kBand, {}};
  ChartSeries truth{"truth", "#000000", ChartSeries::Style::kPoints, {}};
  const UtcTime start = report.light.front().time;
  const auto minutes = [&](UtcTime time) {
    return ChartValue::Exact(std::chrono::duration<double, std::ratio<60>>(time - start).count());
  };
  for (const ReportLight& light : report.light) {
    const double mean = sun ? light.sun : light.sky;
    const double stddev = sun ? light.sun_stddev : light.sky_stddev;
    estimated.points.push_back({minutes(light.time), {mean, mean - stddev, mean + stddev}, ""});
  }
  for (const ReportFrame& frame : report.frames) {
    const auto& true_rgb = sun ? frame.true_sun_irradiance_rgb : frame.true_sky_irradiance_rgb;
    if (!true_rgb) continue;
    truth.points.push_back({minutes(frame.time),
                            ChartValue::Exact((true_rgb->x + true_rgb->y + true_rgb->z) / 3.0),
                            ""});
  }
  const Chart chart{sun ? "Sun: irradiance normal to the beam, mean of RGB"
                        : "Sky: horizontal irradiance, mean of RGB",
                    {"minutes since the first frame", ChartAxis::Scale::kFromZero},
                    {"W/m² per channel (or relative)", ChartAxis::Scale::kFromZero},
                    {std::move(estimated), std::move(truth)}};
  return ChartsForPage(std::span(&chart, 1));
}

struct Stage {
  const char* name;
  double StageTimes::*member;
};
constexpr std::array<Stage, kStageCount> kStages = {{{"read", &StageTimes::read},
                                                     {"transport", &StageTimes::transport},
                                                     {"estimate", &StageTimes::estimate},
                                                     {"relight", &StageTimes::relight},
                                                     {"probes", &StageTimes::probes},
                                                     {"render", &StageTimes::render},
                                                     {"readback", &StageTimes::readback},
                                                     {"write", &StageTimes::write}}};

std::string TimingTable(const ReportTotals& totals) {
  std::string html =
      "<table><tr><th>stage</th><th>median ms</th><th>99 % within ms</th><th>largest "
      "ms</th></tr>\n";
  const auto add = [&](const char* name, const TimeStatistics& times) {
    if (times.Count() == 0) return;
    html += fmt::format("<tr><td>{}</td><td>{:.2f}</td><td>{:.2f}</td><td>{:.2f}</td></tr>\n",
                        name,
                        times.QuantileMs(0.5),
                        times.QuantileMs(0.99),
                        times.LargestMs());
  };
  for (std::size_t i = 0; i < kStageCount; ++i) add(kStages[i].name, totals.stages[i]);
  add("from a frame's timestamp to its composite", totals.latency);
  return html + "</table>\n";
}

// Size of an effect that is left out: its bound or, where the bound is the entire range, its usual
// size.
std::string InCodeValues(double bound, double rms) {
  if (bound < kWhiteCode) return fmt::format("{:.2f} code values at most", bound);
  return fmt::format("about {:.1f} code values, root mean square over the objects' pixels", rms);
}

// Effect by effect, over all frames.
std::string EffectTable(const ReportTotals& totals) {
  std::string html =
      "<table><tr><th>effect</th><th>frames that simulate it</th><th>that keep the last one's</th>"
      "<th>that leave it out</th><th>largest bound left out, code values</th></tr>\n";
  for (const Effect effect : kAllEffects) {
    const auto found = totals.effects.find(effect);
    if (found == totals.effects.end()) continue;
    const auto count = [&](EffectFate fate) {
      return found->second.frames[static_cast<std::size_t>(fate)];
    };
    if (count(EffectFate::kRun) + count(EffectFate::kKept) + count(EffectFate::kLeftOut) == 0) {
      continue;
    }
    html += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{:.2f}</td></tr>\n",
                        NameOf(effect),
                        count(EffectFate::kRun),
                        count(EffectFate::kKept),
                        count(EffectFate::kLeftOut),
                        found->second.largest_left_out_code_values);
  }
  html += fmt::format(
      "</table>\n<p>What a frame left out could change by {}, and saved {:.1f} of {:.1f} ms over "
      "all "
      "frames, as expected from what works took.{}</p>\n",
      InCodeValues(totals.largest_left_out_code_values, totals.largest_left_out_rms_code_values),
      totals.saved_ms,
      totals.all_ms,
      totals.beyond_budget > 0
          ? fmt::format(" {} frames did not fit into the budget.", totals.beyond_budget)
          : std::string());
  return html;
}

std::string EventTable(const RunReport& report) {
  std::string html = "<table><tr><th>time</th><th>event</th><th>frames</th><th></th></tr>\n";
  for (const Event& event : report.events) {
    html += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
                        FormatUtcTime(event.time),
                        NameOf(event.kind),
                        event.count,
                        EscapeHtml(event.text));
  }
  html += "</table>\n";
  if (report.events_left_out > 0) {
    html += fmt::format("<p>{} later events are in events.jsonl.</p>\n", report.events_left_out);
  }
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

std::string FrameSection(const RunReport& report, const ReportFrame& frame) {
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
      frame.is_drawn_without_sun               ? " (sun and sky hardly known: drawn without a sun)"
      : !LightIsKnown(frame.estimate.lighting) ? " (sun and sky hardly known)"
      : ModelMismatch(frame.estimate)          ? " (picture and model do not fit)"
                                               : "",
      LeftOut(frame.plan));
  const auto add = [&](const std::string& caption, const std::optional<SetAside::Place>& picture) {
    if (picture) html += Figure(caption, report.Jpeg(*picture));
  };
  add("input", frame.input);
  add("composite", frame.composite);
  add("truth", frame.truth);
  add(fmt::format("composite less truth, {} times", kDifferenceGain), frame.difference);
  return html + "</div>\n";
}

ReportLight LightOf(const ReportFrame& frame) {
  if (!frame.error.empty()) return {frame.time, kNaN, 0.0, kNaN, 0.0};
  const MeanIrradiance sun = MeanSunIrradiance(frame.lighting);
  const MeanIrradiance sky = MeanSkyIrradiance(frame.lighting);
  return {frame.time, sun.mean, sun.stddev, sky.mean, sky.stddev};
}

void AddTo(ReportTotals& totals, const ReportFrame& frame) {
  ++totals.done;
  for (std::size_t i = 0; i < kStageCount; ++i) {
    totals.stages[i].Add(frame.timing_ms.*kStages[i].member);
  }
  if (frame.latency_ms) totals.latency.Add(*frame.latency_ms);
  const EffectPlan& plan = frame.plan;
  for (const PlannedEffect& planned : plan.effects) {
    ReportTotals::OfEffect& effect = totals.effects[planned.effect];
    ++effect.frames[static_cast<std::size_t>(planned.fate)];
    if (planned.fate == EffectFate::kLeftOut) {
      effect.largest_left_out_code_values =
          std::max(effect.largest_left_out_code_values, planned.bound_code_values);
    }
  }
  totals.largest_left_out_code_values =
      std::max(totals.largest_left_out_code_values, plan.left_out_code_values);
  totals.largest_left_out_rms_code_values =
      std::max(totals.largest_left_out_rms_code_values, plan.left_out_rms_code_values);
  totals.saved_ms += plan.SavedMs();
  totals.all_ms += plan.all_expected_ms;
  totals.beyond_budget += plan.fits_budget ? 0 : 1;
}

// Keeps the items that a doubled stride gives.
template <typename Item>
void KeepEverySecond(std::vector<Item>& items, std::int64_t& stride) {
  for (std::size_t i = 1; 2 * i < items.size(); ++i) items[i] = std::move(items[2 * i]);
  items.resize((items.size() + 1) / 2);
  stride *= 2;
}

}  // namespace

void RunReport::Add(ReportFrame frame) {
  const bool is_shown = ShowsNext();
  const bool is_in_charts = added_ % light_stride_ == 0;
  ++added_;
  if (is_in_charts) {
    light.push_back(LightOf(frame));
    if (light.size() >= kMostLights) KeepEverySecond(light, light_stride_);
  }
  if (frame.error.empty()) {
    AddTo(totals, frame);
  } else {
    ++totals.failed;
    if (totals.first_failure.empty()) {
      totals.first_failure = fmt::format("frame {}: {}", frame.index, frame.error);
    }
  }
  if (!is_shown) return;
  frames.push_back(std::move(frame));
  if (frames.size() >= kMostFrames) KeepEverySecondFrame();
}

void RunReport::KeepEverySecondFrame() {
  KeepEverySecond(frames, stride_);
  std::vector<SetAside::Place*> kept;
  for (ReportFrame& frame : frames) {
    for (std::optional<SetAside::Place>* picture : {&frame.input, &frame.composite}) {
      if (*picture) kept.push_back(&**picture);
    }
  }
  pictures_.KeepOnly(kept);
}

void RunReport::LeavePicturesOut() {
  for (ReportFrame& frame : frames) {
    frame.input = frame.composite = frame.truth = frame.difference = std::nullopt;
  }
}

void RunReport::AddEvent(Event event) {
  // Losses come every second of a machine that is too slow: they must not hide what is rare.
  const bool is_loss = event.kind == EventKind::kFrameDropped ||
                       event.kind == EventKind::kFrameLost ||
                       event.kind == EventKind::kFrameDamaged;
  if (events.size() < (is_loss ? kMostEvents / 2 : kMostEvents)) {
    events.push_back(std::move(event));
  } else {
    ++events_left_out;
  }
}

SetAside::Place RunReport::AddPicture(const Rgb8Image& image) {
  if (image.width > kLargestPictureWidthPx) {
    const double scale = double(kLargestPictureWidthPx) / image.width;
    Rgb8Image reduced(kLargestPictureWidthPx,
                      std::max(1, static_cast<int>(std::lround(scale * image.height))));
    // OpenCV does not write through its input; the cast is for its constructor alone.
    const cv::Mat full(
        image.height, image.width, CV_8UC3, const_cast<glm::u8vec3*>(image.pixels.data()));
    cv::Mat into(reduced.height, reduced.width, CV_8UC3, reduced.pixels.data());
    cv::resize(full, into, into.size(), 0.0, 0.0, cv::INTER_AREA);
    return AddPicture(reduced);
  }
  const std::vector<std::byte> jpeg = JpegOf(image, kJpegQuality);
  return pictures_.Add({reinterpret_cast<const char*>(jpeg.data()), jpeg.size()});
}

void WriteRunReport(const std::filesystem::path& file, const RunReport& report) {
  std::string html = fmt::format(
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{0}</title>"
      "<style>{1}</style></head>\n<body><h1>{0}</h1>\n",
      EscapeHtml(report.title),
      kStyle);
  html += List(report.settings);
  if (!report.notes.empty()) html += "<h2>Notes</h2>\n" + List(report.notes);
  if (!report.events.empty()) html += "<h2>Events</h2>\n" + EventTable(report);
  if (report.totals.done > 0) {
    html += "<h2>Light over time</h2>\n" + LightChart(report, true) + "<br>\n" +
            LightChart(report, false) + "\n";
    html += "<h2>Time per stage</h2>\n" + TimingTable(report.totals);
    html += "<h2>Effects</h2>\n" + EffectTable(report.totals);
  }
  if (!report.frames.empty()) html += "<h2>Frames</h2>\n";
  const std::int64_t all = report.totals.done + report.totals.failed;
  if (all > static_cast<std::int64_t>(report.frames.size())) {
    html +=
        fmt::format("<p>{} of {} frames, evenly over the run.</p>\n", report.frames.size(), all);
  }
  for (const ReportFrame& frame : report.frames) html += FrameSection(report, frame);
  html += "</body></html>\n";

  WriteWholeText(file, html);
}

}  // namespace pleinair
