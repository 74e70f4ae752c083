#include "apps/tradeoff_command.h"

#include <algorithm>
#include <fstream>
#include <functional>
#include <iterator>
#include <stdexcept>
#include <thread>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include "apps/front_page.h"
#include "apps/imperfection_page.h"
#include "apps/progress.h"
#include "apps/run_folder.h"
#include "apps/tradeoff_page.h"
#include "datasets/truth.h"
#include "scene/whole_file.h"

namespace pleinair {
namespace {

// As the system reports it; empty where it does not.
std::string ProcessorName() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (!line.starts_with("model name")) continue;
    const std::size_t colon = line.find(": ");
    return colon == std::string::npos ? std::string() : line.substr(colon + 2);
  }
  return {};
}

std::vector<SweepAxis> ChosenAxes(const std::vector<std::string>& names, const SweepCase& here) {
  std::vector<SweepAxis> axes = SweepAxesFor(here);
  if (names.empty()) return axes;
  for (const std::string& name : names) {
    const bool is_there = std::any_of(
        axes.begin(), axes.end(), [&](const SweepAxis& axis) { return axis.setting == name; });
    if (is_there) continue;
    std::string all;
    for (const SweepAxis& axis : axes) all.append(all.empty() ? "" : ", ").append(axis.setting);
    throw std::invalid_argument(
        fmt::format("--sweep {}: expected front, {}, or settings of this sequence: {}",
                    name,
                    kImperfectionSweep,
                    all));
  }
  std::erase_if(axes, [&](const SweepAxis& axis) {
    return std::find(names.begin(), names.end(), axis.setting) == names.end();
  });
  return axes;
}

std::string MachineLine() {
  return fmt::format("{}, {} threads; pleinair {}",
                     ProcessorName(),
                     std::thread::hardware_concurrency(),
                     PLEINAIR_VERSION);
}

// Where it could be drawn; the page says why it could not.
void WriteChart(const std::filesystem::path& file, const std::string& svg) {
  if (svg.starts_with("<svg")) WriteWholeText(file, svg);
}

std::string SweepAxes(const TradeoffCommandOptions& options,
                      const TrialSettings& settings,
                      const std::vector<std::string>& names) {
  TradeoffTrials trials(settings, ProgressOnStandardError());
  const SweepCase here = trials.Case();
  const std::vector<SweepAxis> axes = ChosenAxes(names, here);
  const Sequence& sequence = trials.Loaded().sequence;
  if (axes.empty()) {
    throw std::runtime_error(sequence.folder.string() +
                             ": its light is measured by a fish-eye and its truth has no pictures "
                             "with the object: expected something to measure errors");
  }
  for (const SweepAxis& axis : axes) spdlog::info("{}: {}", axis.setting, axis.Words());
  MakeFolder(options.out);

  TradeoffPage page;
  page.title = "Error against time: " + sequence.NameOrFolder();
  page.settings = {
      fmt::format("{}x{} pixels; light measured on {} frames, pictures on {}",
                  sequence.intrinsics.width_px,
                  sequence.intrinsics.height_px,
                  here.light_is_fitted ? trials.LightFrames() : trials.PictureFrames(),
                  trials.PictureFrames()),
      fmt::format("{} seeds where the light alone is estimated, {} where rays or pictures are "
                  "recomputed; no filter over time, {}",
                  settings.seeds,
                  settings.costly_seeds,
                  OtherSettingsInWords(settings)),
      MachineLine(),
      "the recording's frames are minutes apart: each pays for a new sun, which a camera's frames "
      "share for 48 s"};
  page.axes = trials.Measure(axes);
  for (const SweptAxis& swept : page.axes) {
    for (const SweepResult& result : swept.results) {
      if (result.failure.empty()) continue;
      spdlog::warn("{} {}: {}", swept.axis.setting, result.value, result.failure);
    }
  }
  WriteWholeText(options.out / "tradeoff.csv", TradeoffCsv(page));
  WriteWholeText(options.out / "tradeoff.html", TradeoffHtml(page));
  return DefaultsText(page) + (options.out / "tradeoff.html").string();
}

// Whether a picture's error can be measured.
bool HasPictures(const std::filesystem::path& folder) {
  const Sequence sequence = ReadSequence(folder);
  if (sequence.virtual_objects.empty() || !HasTruth(sequence)) return false;
  const std::vector<TruthFrame> truth = ReadTruth(sequence);
  return std::any_of(truth.begin(), truth.end(), std::mem_fn(&TruthFrame::HasPicture));
}

std::string SearchTheFront(const TradeoffCommandOptions& options, const TrialSettings& settings) {
  FrontTrials trials(settings, ProgressOnStandardError());
  MakeFolder(options.out);
  FrontPage page;
  const CameraIntrinsics& camera = trials.Recording().intrinsics;
  page.title = "What a frame costs, and what comes of it: " + trials.Recording().NameOrFolder();
  page.points = trials.Search(options.most_combinations);
  page.settings = {fmt::format("{}x{} pixels, {} frames, {} seeds; {} combinations tried",
                               camera.width_px,
                               camera.height_px,
                               trials.Frames(),
                               settings.costly_seeds,
                               page.points.size()),
                   "times are ratios to the default's, measured side by side, times its median",
                   "no filter over time, " + OtherSettingsInWords(settings),
                   MachineLine()};
  for (const FrontPoint& point : page.points) {
    if (!point.failure.empty()) spdlog::warn("a combination failed: {}", point.failure);
  }
  WriteWholeText(options.out / "front.csv", FrontCsv(page));
  WriteChart(options.out / "front.svg", FrontChart(page));
  WriteWholeText(options.out / "front.html", FrontHtml(page));
  return QualitiesInWords(page) + (options.out / "front.html").string();
}

// None where the names are of something else.
std::vector<ImperfectionDial> ChosenImperfections(const std::vector<std::string>& names) {
  const std::vector<ImperfectionDial> all = ImperfectionDials();
  std::vector<ImperfectionDial> chosen;
  std::size_t known = 0;
  for (const std::string& name : names) {
    const auto begin = chosen.size();
    std::copy_if(all.begin(), all.end(), std::back_inserter(chosen), [&](const auto& dial) {
      return name == kImperfectionSweep || name == dial.name;
    });
    known += chosen.size() > begin ? 1 : 0;
  }
  if (chosen.empty() || known == names.size()) return chosen;
  std::vector<std::string> expected{kImperfectionSweep};
  for (const ImperfectionDial& dial : all) expected.push_back(dial.name);
  throw std::invalid_argument(
      fmt::format("--sweep {}: expected settings alone, or imperfections alone: {}",
                  fmt::join(names, ","),
                  fmt::join(expected, ", ")));
}

std::string SweepImperfections(const TradeoffCommandOptions& options,
                               const std::vector<ImperfectionDial>& dials) {
  const TrialSettings& trials = options.trials;
  ImperfectionSettings settings;
  settings.sequences = options.sequences;
  settings.seeds = trials.costly_seeds;
  settings.session = trials.session;
  if (options.frames_limit) settings.frames_limit = *options.frames_limit;
  ImperfectionPage page;
  page.dials = dials;
  page.recordings = MeasureImperfections(settings, page.dials, ProgressOnStandardError());
  std::vector<std::string> recordings;
  for (const ImperfectRecording& recording : page.recordings) {
    recordings.push_back(fmt::format("{} ({} frames)", recording.name, recording.frames));
    for (std::size_t dial = 0; dial < page.dials.size(); ++dial) {
      for (const ImperfectionResult& result : recording.dials[dial]) {
        if (result.failure.empty()) continue;
        spdlog::warn(
            "{}, {} {:g}: {}", recording.name, page.dials[dial].name, result.size, result.failure);
      }
    }
  }
  page.settings = {fmt::format("{}", fmt::join(recordings, ", ")),
                   fmt::format("{} seeds; 8-bit frames with a camera's noise; pleinair {}; {}",
                               settings.seeds,
                               PLEINAIR_VERSION,
                               OtherSettingsInWords(trials))};
  MakeFolder(options.out);
  WriteWholeText(options.out / "imperfections.csv", ImperfectionCsv(page));
  WriteChart(options.out / "imperfections.svg", ImperfectionOverview(page));
  WriteWholeText(options.out / "imperfections.md", ImperfectionMarkdown(page));
  WriteWholeText(options.out / "imperfections.html", ImperfectionHtml(page));
  return ImperfectionsInWords(page) + (options.out / "imperfections.html").string();
}

}  // namespace

std::string RunTradeoffCommand(const TradeoffCommandOptions& options) {
  for (const std::filesystem::path& sequence : options.sequences) {
    RequireApart(options.out, sequence);
  }
  const std::vector<ImperfectionDial> imperfections = ChosenImperfections(options.sweep);
  if (!imperfections.empty()) return SweepImperfections(options, imperfections);
  if (options.sequences.size() != 1) {
    throw std::invalid_argument(fmt::format(
        "{} sequences: expected one, or --sweep {}", options.sequences.size(), kImperfectionSweep));
  }
  TrialSettings settings = options.trials;
  settings.session.sequence = options.sequences.front();
  if (options.frames_limit) settings.frames_limit = *options.frames_limit;
  std::vector<std::string> axes = options.sweep;
  const bool with_front = std::erase(axes, kFrontSweep) > 0 ||
                          (options.sweep.empty() && HasPictures(settings.session.sequence));
  std::string said;
  if (!axes.empty() || options.sweep.empty()) said = SweepAxes(options, settings, axes);
  if (with_front) said += (said.empty() ? "" : "\n") + SearchTheFront(options, settings);
  return said;
}

}  // namespace pleinair
