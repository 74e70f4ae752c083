// `pleinair tradeoff`, coarse enough to be quick.
#include "apps/tradeoff_command.h"

#include <set>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/imperfection_trials.h"
#include "tests/session/command_folder.h"

namespace pleinair::tradeoff_command_test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const fs::path kCourtyard = PLEINAIR_SOURCE_DIR "/datasets/samples/courtyard";

class TradeoffCommand : public CommandFolder {
 protected:
  TradeoffCommandOptions Quick(std::vector<std::string> sweep) const {
    TradeoffCommandOptions options;
    options.sequences = {kCourtyard};
    options.trials.session.cache = folder_ / "cache";
    options.trials.seeds = 3;
    options.trials.costly_seeds = 1;
    options.frames_limit = 1;
    options.trials.session.prepare.patch_size_m = 4.0;
    options.trials.session.prepare.rays = 16;
    options.out = folder_ / "out";
    options.sweep = std::move(sweep);
    return options;
  }
  std::string Read(const char* name) const {
    std::ifstream stream(folder_ / "out" / name);
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
  }
};

TEST_F(TradeoffCommand, ReportsErrorAndTimeOfEachSetting) {
  const std::string said =
      RunTradeoffCommand(Quick({"light.fit.solver", "light.samples", "influence_at"}));
  EXPECT_THAT(said,
              AllOf(HasSubstr("light.fit.solver: the default, ceres, "),
                    HasSubstr("light.samples: the default, 500, "),
                    HasSubstr("influence_at: the default, pixels, ")));
  const std::string csv = Read("tradeoff.csv");
  std::istringstream lines(csv);
  std::string line;
  std::getline(lines, line);
  const auto commas = std::count(line.begin(), line.end(), ',');
  int rows = 0;
  int on_front = 0;
  std::set<std::string> errors_of_solvers;
  for (; std::getline(lines, line); ++rows) {
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), commas) << line;
    std::vector<std::string> cells;
    std::istringstream row(line);
    for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
    EXPECT_GT(std::stod(cells.at(6)), 0.0) << "error in " << line;
    EXPECT_GT(std::stod(cells.at(9)), 0.0) << "time in " << line;
    EXPECT_EQ(cells.at(5), cells.at(0) == "influence_at" ? "1" : "3") << "seeds in " << line;
    on_front += cells.at(3) == "1" ? 1 : 0;
    if (cells.at(0) == "light.fit.solver") errors_of_solvers.insert(cells.at(6));
  }
  EXPECT_EQ(rows, 9 + 2 + 2);
  EXPECT_GE(on_front, 3) << "every axis has a front";
  EXPECT_EQ(errors_of_solvers.size(), 1u) << "two ways to one optimum";

  const std::string html = Read("tradeoff.html");
  EXPECT_THAT(html, AllOf(HasSubstr("<svg"), HasSubstr("Pareto front"), HasSubstr("</html>")));
  EXPECT_THAT(html, AllOf(Not(HasSubstr("src=\"http")), Not(HasSubstr("href=\"http"))))
      << "one file that needs nothing else";
}

TEST_F(TradeoffCommand, RefusesWhatItCannotSweep) {
  const auto refusal = [](const TradeoffCommandOptions& options) {
    return Refusal(RunTradeoffCommand, options);
  };
  EXPECT_THAT(refusal(Quick({"light.samples", "colour"})),
              AllOf(HasSubstr("--sweep colour: "),
                    HasSubstr("light.samples, light.choice, light.fit.loss")));
  EXPECT_THAT(refusal(Quick({"sky_regions"})), HasSubstr("--sweep sky_regions"))
      << "there is no fish-eye outdoors";
  EXPECT_THAT(
      refusal(Quick({"light.samples", "north_deg"})),
      AllOf(HasSubstr("--sweep light.samples,north_deg: expected"), HasSubstr("imperfections")));
  TradeoffCommandOptions two = Quick({"light.samples"});
  two.sequences.push_back(kCourtyard);
  EXPECT_THAT(refusal(two), HasSubstr("2 sequences: expected one"));
  EXPECT_FALSE(fs::exists(folder_ / "out"));

  TradeoffCommandOptions blind = Quick({"light.samples"});
  blind.sequences = {folder_ / "blind"};
  fs::create_directories(blind.sequences[0]);
  for (const fs::directory_entry& entry : fs::directory_iterator(kCourtyard)) {
    if (entry.path().filename() == "truth") continue;
    fs::copy(
        entry.path(), blind.sequences[0] / entry.path().filename(), fs::copy_options::recursive);
  }
  EXPECT_THAT(refusal(blind), HasSubstr("truth.json: expected the truth"));
  blind.sweep = {"imperfections"};
  EXPECT_THAT(refusal(blind), HasSubstr("truth.json: expected the truth"));
}

// A gamma that is off by a quarter makes shadows that are much too dark or too bright.
TEST_F(TradeoffCommand, StatesWhatAnImperfectionCosts) {
  TradeoffCommandOptions options = Quick({"curve"});
  const std::string said = RunTradeoffCommand(options);
  EXPECT_THAT(said, HasSubstr("off by a factor of exp of 0.06: sun over sky is "));
  const std::string csv = Read("imperfections.csv");
  std::istringstream lines(csv);
  std::string line;
  std::getline(lines, line);
  const auto commas = std::count(line.begin(), line.end(), ',');
  std::vector<double> light;
  std::vector<double> objects;
  while (std::getline(lines, line)) {
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), commas) << line;
    std::vector<std::string> cells;
    std::istringstream row(line);
    for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
    light.push_back(std::stod(cells.at(4)));
    objects.push_back(std::stod(cells.at(13)));
  }
  ASSERT_EQ(light.size(), 6u) << "without, and five sizes";
  EXPECT_GT(light[5], 3.0 * light[0]);
  EXPECT_GT(light[5], 3.0 * light[1]);
  EXPECT_GT(objects[0], 0.0);
  EXPECT_THAT(Read("imperfections.svg"), testing::StartsWith("<svg"));
  EXPECT_THAT(Read("imperfections.md"), HasSubstr("| curve | "));
  EXPECT_THAT(Read("imperfections.html"), AllOf(HasSubstr("<svg"), HasSubstr("</html>")));
}

TEST_F(TradeoffCommand, AnImperfectionCostsTheSameEachTime) {
  ImperfectionSettings settings;
  settings.sequences = {kCourtyard};
  settings.session.cache = folder_ / "cache";
  settings.seeds = 1;
  settings.frames_limit = 1;
  settings.session.prepare.patch_size_m = 4.0;
  settings.session.prepare.rays = 16;
  ImperfectionDial dial = ImperfectionDials().front();
  dial.sizes = {dial.usual};
  const auto measure = [&] {
    const ImperfectRecording measured =
        MeasureImperfections(settings, {dial}, [](auto, auto) {}).at(0);
    return std::pair(measured.perfect.runs.at(0), measured.dials.at(0).at(0).runs.at(0));
  };
  const auto [without, with] = measure();
  EXPECT_NE(without, with);
  EXPECT_EQ(measure(), std::pair(without, with));
}

TEST(ImperfectionDials, HaveFiveAscendingOrDescendingSizesAndTheUsualAmongThem) {
  std::set<std::string> names;
  for (const ImperfectionDial& dial : ImperfectionDials()) {
    EXPECT_TRUE(names.insert(dial.name).second) << dial.name;
    ASSERT_EQ(dial.sizes.size(), 5u) << dial.name;
    EXPECT_EQ(std::count(dial.sizes.begin(), dial.sizes.end(), dial.usual), 1) << dial.name;
    const bool ascends = dial.sizes[1] > dial.sizes[0];
    for (std::size_t i = 1; i < dial.sizes.size(); ++i) {
      EXPECT_EQ(dial.sizes[i] > dial.sizes[i - 1], ascends) << dial.name;
    }
    // Each turns something, which can be written.
    Imperfections imperfections;
    dial.set(imperfections, dial.usual);
    EXPECT_NO_THROW(imperfections.Validate()) << dial.name;
  }
  EXPECT_EQ(names.size(), 14u);
}

TEST(SweepAxes, EveryAxisHasItsDefaultAmongItsValues) {
  for (const bool fitted : {false, true}) {
    for (const bool indoors : {false, true}) {
      std::set<std::string> names;
      for (const SweepAxis& axis : SweepAxesFor({fitted, true, indoors, InfluenceAt::kFaces})) {
        EXPECT_TRUE(names.insert(axis.setting).second) << axis.setting << " occurs twice";
        const auto defaults =
            std::count_if(axis.values.begin(), axis.values.end(), [&](const SweepValue& value) {
              return value.text == axis.default_text;
            });
        EXPECT_EQ(defaults, 1) << axis.setting;
      }
      EXPECT_EQ(names.contains("light.samples"), fitted);
      EXPECT_EQ(names.contains("sky_regions"), !fitted);
      EXPECT_EQ(names.contains("pipeline.object_light.direct_daylight.sampling.restriction"),
                indoors);
    }
  }
  EXPECT_TRUE(SweepAxesFor({false, false, true, InfluenceAt::kFaces}).empty());
}

}  // namespace
}  // namespace pleinair::tradeoff_command_test
