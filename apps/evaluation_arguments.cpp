#include "apps/evaluation_arguments.h"

#include <memory>
#include <string>

#include <CLI/CLI.hpp>

#include "apps/regress_command.h"
#include "apps/settings_arguments.h"
#include "apps/tradeoff_command.h"

namespace pleinair {
namespace {

constexpr int kGotWorse = 1;

int PrintRegression(const RegressResult& result) {
  Print(result.table);
  for (const std::string& reason : result.reasons) PrintError(reason);
  return result.reasons.empty() ? 0 : kGotWorse;
}

}  // namespace

void AddRegress(CLI::App& app, Work& work) {
  auto options = std::make_shared<RegressCommandOptions>();
  CLI::App& regress = *app.add_subcommand(
      "regress", "Runs and scores sequences; exit code 1 where a figure got worse");
  regress.footer("Example: pleinair regress datasets/samples");
  regress.add_option("folder", options->folder, "A sequence, or a folder of sequences")
      ->type_name("FOLDER")
      ->required();
  regress
      .add_option("--baseline",
                  options->baseline,
                  "the figures to compare with (default: baseline.json in the folder)")
      ->type_name("FILE");
  regress.add_option("--out", options->out, "JSON to write")->type_name("FILE");
  regress
      .add_option("--seeds",
                  options->seeds,
                  "draws of samples: a figure is the median over them (default 1; 5 for a "
                  "baseline, whose spread over them is the noise)")
      ->check(CLI::Range(1, 1000));
  CLI::Option* write = regress.add_flag(
      "--write-baseline",
      options->write_baseline,
      "write the baseline instead of checking against it; its other sequences stay");
  FigureSettings& settings = options->settings;
  regress
      .add_option("--frames-limit",
                  settings.frames_limit,
                  "for the baseline: so many frames, spread over each sequence; 0: all")
      ->check(CLI::Range(0, 1000000))
      ->needs(write);
  regress
      .add_flag_function(
          "--light-alone",
          [&settings](std::int64_t) { settings.pictures = false; },
          "for the baseline: no composites, which take most of the time")
      ->needs(write);
  regress
      .add_option("--cache",
                  options->cache,
                  "folder for prepared data (default: pleinair in the user's cache folder)")
      ->type_name("FOLDER");
  auto given = std::make_shared<GivenSettings>();
  AddSettings(regress, *given);
  regress.callback([options, given, &work] {
    work = [options, given] {
      SessionOptions allowed;
      options->settings.assignments = given->ApplyTo(allowed);
      return PrintRegression(RunRegressCommand(*options));
    };
  });
}

void AddTradeoff(CLI::App& app, Work& work) {
  auto options = std::make_shared<TradeoffCommandOptions>();
  options->out = "pleinair-tradeoff";
  CLI::App& tradeoff = *app.add_subcommand(
      "tradeoff", "Error against time for the settings, on a recorded sequence with truth");
  tradeoff.footer(
      "Example: pleinair tradeoff datasets/samples/courtyard --sweep light.samples,light.fit.loss "
      "--out tradeoff");
  TrialSettings& trials = options->trials;
  tradeoff
      .add_option("sequence",
                  options->sequences,
                  "folder with sequence.json and truth/; for imperfections any number of them")
      ->type_name("FOLDER")
      ->required();
  tradeoff.add_option("--out", options->out, "folder for tradeoff.csv and tradeoff.html")
      ->type_name("FOLDER")
      ->default_str("pleinair-tradeoff");
  tradeoff
      .add_option(
          "--sweep",
          options->sweep,
          "settings to sweep, by the names that `pleinair settings` lists (default: all that mean "
          "something for the sequence; another name lists them). front: combinations of them. "
          "Or imperfections, all or by name (gain,exposure,veil,vignette,saturation,curve,sharpen,"
          "jpeg,pose_deg,pose_m,mesh_m,north_deg,clip,albedo): what they cost, one at a time")
      ->type_name("NAME,...")
      ->delimiter(',');
  tradeoff
      .add_option("--seeds", trials.seeds, "seeds for settings that only the estimate depends on")
      ->check(CLI::Range(1, 1000));
  tradeoff
      .add_option("--costly-seeds",
                  trials.costly_seeds,
                  "seeds for settings that need new rays or pictures, and for imperfections")
      ->check(CLI::Range(1, 1000));
  tradeoff
      .add_option("--frames-limit",
                  options->frames_limit,
                  "frames, spread over the sequence (default 24; for imperfections 4)")
      ->check(CLI::Range(1, 100000));
  tradeoff
      .add_option("--combinations",
                  options->most_combinations,
                  "combinations of settings that are tried for the front")
      ->check(CLI::Range(1, 10000));
  tradeoff
      .add_option("--cache",
                  trials.session.cache,
                  "folder for prepared data (default: pleinair in the user's cache folder)")
      ->type_name("FOLDER");
  auto given = std::make_shared<GivenSettings>();
  AddSettings(tradeoff, *given);
  tradeoff.callback([options, given, &work] {
    work = [options, given] {
      options->trials.assignments = given->ApplyTo(options->trials.session);
      return Print(RunTradeoffCommand(*options));
    };
  });
}

}  // namespace pleinair
