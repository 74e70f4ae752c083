#include "apps/regress_command.h"

#include <algorithm>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <nlohmann/json.hpp>

#include "apps/regression_baseline.h"
#include "scene/whole_file.h"

namespace pleinair {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Outcome = FigureComparison::Outcome;

constexpr int kSeedsOfABaseline = 5;

struct SequenceRegression {
  std::string name;
  bool has_baseline = false;
  std::string error;  // Why it could not be run; then there are no figures.
  std::vector<FigureComparison> figures;
};

// `folder` itself, or those in it, by name.
std::vector<fs::path> SequencesIn(const fs::path& folder) {
  if (!fs::is_directory(folder)) {
    throw std::runtime_error(folder.string() + ": expected a sequence, or a folder of sequences");
  }
  if (fs::exists(folder / "sequence.json")) return {fs::canonical(folder)};
  std::vector<fs::path> sequences;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (fs::exists(entry.path() / "sequence.json")) sequences.push_back(entry.path());
  }
  std::sort(sequences.begin(), sequences.end());
  if (sequences.empty()) {
    throw std::runtime_error(folder.string() + ": expected folders with a sequence.json in it");
  }
  return sequences;
}

std::string NameOf(const fs::path& sequence) { return sequence.filename().string(); }

const char* Word(const FigureComparison& figure) {
  switch (figure.outcome) {
    case Outcome::kSame:
      return "";
    case Outcome::kBetter:
      return "better";
    case Outcome::kWorse:
      return "WORSE";
    case Outcome::kNew:
      return "new";
    case Outcome::kGone:
      return "GONE";
  }
  return "";
}

std::string Cell(const std::optional<double>& value) {
  return value ? fmt::format("{:.4g}", *value) : "-";
}

std::string TableOf(const std::vector<SequenceRegression>& sequences) {
  std::string table;
  for (const SequenceRegression& sequence : sequences) {
    table += fmt::format("{:<56}{:>12}{:>12}{:>12}\n", sequence.name, "now", "baseline", "noise");
    if (!sequence.error.empty()) table += "  cannot be run: " + sequence.error + "\n";
    for (const FigureComparison& figure : sequence.figures) {
      const bool compared = figure.baseline.has_value();
      std::string line = fmt::format("  {:<54}{:>12}{:>12}{:>12}  {}",
                                     figure.kind.words,
                                     Cell(figure.now),
                                     Cell(figure.baseline),
                                     compared ? Cell(figure.noise) : "-",
                                     Word(figure));
      line.erase(line.find_last_not_of(' ') + 1);
      table += line + "\n";
    }
    table += "\n";
  }
  return table;
}

Json Number(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

std::string JsonOf(const std::vector<SequenceRegression>& sequences,
                   const std::vector<std::string>& reasons) {
  Json json = {
      {"got_worse", !reasons.empty()}, {"reasons", reasons}, {"sequences", Json::object()}};
  for (const SequenceRegression& sequence : sequences) {
    Json& entry = json["sequences"][sequence.name];
    entry["has_baseline"] = sequence.has_baseline;
    entry["error"] = sequence.error.empty() ? Json(nullptr) : Json(sequence.error);
    entry["figures"] = Json::object();
    for (const FigureComparison& figure : sequence.figures) {
      const bool compared = figure.baseline.has_value();
      entry["figures"][figure.kind.name] = {{"now", Number(figure.now)},
                                            {"baseline", Number(figure.baseline)},
                                            {"noise", compared ? Json(figure.noise) : Json()},
                                            {"limit", compared ? Json(figure.limit) : Json()},
                                            {"higher_is_better", figure.kind.higher_is_better},
                                            {"got_worse", figure.GotWorse()}};
    }
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::vector<std::string> ReasonsOf(const std::vector<SequenceRegression>& sequences) {
  std::vector<std::string> reasons;
  for (const SequenceRegression& sequence : sequences) {
    if (!sequence.error.empty()) {
      reasons.push_back(sequence.name + ": cannot be run: " + sequence.error);
    }
    for (const FigureComparison& figure : sequence.figures) {
      if (figure.GotWorse()) reasons.push_back(sequence.name + ": " + figure.Reason());
    }
  }
  return reasons;
}

SequenceRegression Check(const fs::path& folder,
                         const SequenceBaseline* baseline,
                         const RegressCommandOptions& options) {
  SequenceRegression regression;
  regression.name = NameOf(folder);
  regression.has_baseline = baseline != nullptr;
  const SequenceBaseline before = baseline != nullptr ? *baseline : SequenceBaseline{};
  const SeededFigures now =
      MeasureFigures(folder, before.settings, options.seeds.value_or(1), options.cache);
  regression.figures = CompareFigures(before.figures, now);
  return regression;
}

RegressResult WriteBaseline(const RegressCommandOptions& options,
                            const fs::path& file,
                            const std::vector<fs::path>& sequences) {
  RegressionBaseline baseline;
  if (fs::exists(file)) baseline = ReadRegressionBaseline(file);
  std::vector<SequenceRegression> shown;
  for (const fs::path& folder : sequences) {
    spdlog::info("{}", NameOf(folder));
    SequenceBaseline& entry = baseline[NameOf(folder)];
    const SeededFigures before = entry.figures;
    entry.settings = options.settings;
    entry.figures = MeasureFigures(
        folder, options.settings, options.seeds.value_or(kSeedsOfABaseline), options.cache);
    shown.push_back({NameOf(folder), !before.empty(), "", CompareFigures(before, entry.figures)});
  }
  WriteRegressionBaseline(baseline, file);
  spdlog::info("{}: {} sequences", file.string(), baseline.size());
  if (!options.out.empty()) WriteWholeText(options.out, JsonOf(shown, {}));
  return {TableOf(shown), {}};
}

}  // namespace

RegressResult RunRegressCommand(const RegressCommandOptions& options) {
  const std::vector<fs::path> sequences = SequencesIn(options.folder);
  const fs::path file =
      options.baseline.empty() ? options.folder / "baseline.json" : options.baseline;
  if (options.write_baseline) return WriteBaseline(options, file, sequences);
  if (options.settings != FigureSettings{}) {
    throw std::invalid_argument(
        "a check measures as its baseline did: --frames-limit, --light-alone, --set and "
        "--settings go with --write-baseline");
  }
  const RegressionBaseline baseline = ReadRegressionBaseline(file);
  std::vector<SequenceRegression> checked;
  for (const fs::path& folder : sequences) {
    const auto found = baseline.find(NameOf(folder));
    const bool has_baseline = found != baseline.end();
    spdlog::info("{}", NameOf(folder));
    if (!has_baseline) {
      spdlog::warn(
          "{}: {} has no figures of it (see --write-baseline)", NameOf(folder), file.string());
    }
    try {
      checked.push_back(Check(folder, has_baseline ? &found->second : nullptr, options));
    } catch (const std::exception& error) {
      // One sequence alone is the input; one of many does not stop the others.
      if (sequences.size() == 1) throw;
      checked.push_back({NameOf(folder), has_baseline, error.what(), {}});
    }
  }
  for (const auto& entry : baseline) {
    const std::string& name = entry.first;
    const bool is_there = std::any_of(checked.begin(), checked.end(), [&](const auto& sequence) {
      return sequence.name == name;
    });
    if (!is_there && checked.size() > 1) {
      spdlog::warn("{} is in {}, but not in {}", name, file.string(), options.folder.string());
    }
  }
  RegressResult result{TableOf(checked), ReasonsOf(checked)};
  if (!options.out.empty()) WriteWholeText(options.out, JsonOf(checked, result.reasons));
  return result;
}

}  // namespace pleinair
