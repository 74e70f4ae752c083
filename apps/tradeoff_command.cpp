#include "apps/tradeoff_command.h"

#include <algorithm>
#include <fstream>
#include <stdexcept>
#include <thread>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "apps/progress.h"
#include "apps/run_folder.h"
#include "apps/tradeoff_page.h"
#include "apps/whole_text.h"

namespace pleinair {
namespace {

// As the system tells it; empty where it doesn't.
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
        axes.begin(), axes.end(), [&](const SweepAxis& axis) { return axis.name == name; });
    if (is_there) continue;
    std::string all;
    for (const SweepAxis& axis : axes) all.append(all.empty() ? "" : ",").append(axis.name);
    throw std::invalid_argument(fmt::format("--sweep {}: this sequence has {}", name, all));
  }
  std::erase_if(axes, [&](const SweepAxis& axis) {
    return std::find(names.begin(), names.end(), axis.name) == names.end();
  });
  return axes;
}

}  // namespace

std::string RunTradeoffCommand(const TradeoffCommandOptions& options) {
  RequireApart(options.out, options.trials.sequence);
  TradeoffTrials trials(options.trials, ProgressOnStandardError());
  const SweepCase here = trials.Case();
  const std::vector<SweepAxis> axes = ChosenAxes(options.sweep, here);
  const Sequence& sequence = trials.Loaded().sequence;
  if (axes.empty()) {
    throw std::runtime_error(sequence.folder.string() +
                             ": its light is measured by a fish-eye and its truth has no pictures "
                             "with the object: expected something to tell errors by");
  }
  for (const SweepAxis& axis : axes) spdlog::info("{}: {}", axis.name, axis.words);
  std::filesystem::create_directories(options.out);

  TradeoffPage page;
  page.title = "Error against time: " +
               (sequence.name.empty() ? sequence.folder.filename().string() : sequence.name);
  page.settings = {
      fmt::format("{}x{} pixels; light measured on {} frames, pictures on {}",
                  sequence.intrinsics.width_px,
                  sequence.intrinsics.height_px,
                  here.light_is_fitted ? trials.LightFrames() : trials.PictureFrames(),
                  trials.PictureFrames()),
      fmt::format("{} seeds where the light alone is estimated, {} where rays or pictures are made "
                  "anew; no filter over time, all other settings at their defaults",
                  options.trials.seeds,
                  options.trials.costly_seeds),
      fmt::format("{}, {} threads; pleinair {}",
                  ProcessorName(),
                  std::thread::hardware_concurrency(),
                  PLEINAIR_VERSION),
      "the recording's frames are minutes apart: each pays for a new sun, which a camera's frames "
      "share for 48 s"};
  page.axes = trials.Measure(axes);
  for (const SweptAxis& swept : page.axes) {
    for (const SweepResult& result : swept.results) {
      if (result.failure.empty()) continue;
      spdlog::warn("{} {}: {}", swept.axis.name, result.value, result.failure);
    }
  }
  WriteWholeText(options.out / "tradeoff.csv", TradeoffCsv(page));
  WriteWholeText(options.out / "tradeoff.html", TradeoffHtml(page));
  return DefaultsText(page) + (options.out / "tradeoff.html").string();
}

}  // namespace pleinair
