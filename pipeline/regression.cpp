#include "pipeline/regression.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>

#include "datasets/statistics.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

std::string Text(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.4g", value);
  return text;
}

using Figure = std::optional<double>;

Figure PartOf(const std::optional<Distribution>& of, double Distribution::*part) {
  return of ? Figure(*of.*part) : std::nullopt;
}

// Over the frames that have the fact.
template <auto kFact, double Distribution::*kPart>
Figure OfFrames(const RunToJudge& run) {
  std::vector<double> values;
  for (const FrameFacts& frame : run.done) {
    if (const std::optional<double> value = std::invoke(kFact, frame)) values.push_back(*value);
  }
  return PartOf(DistributionOf(values), kPart);
}

template <std::optional<std::int64_t> FrameFacts::*kFact>
Figure SumOf(const RunToJudge& run) {
  Figure sum;
  for (const FrameFacts& frame : run.done) {
    if (frame.*kFact) sum = sum.value_or(0.0) + static_cast<double>(*(frame.*kFact));
  }
  return sum;
}

// Over the frames that a person judged so.
template <bool kSunshine, double Distribution::*kPart>
Figure SunOverSkyWhereJudged(const RunToJudge& run) {
  std::vector<double> values;
  for (const FrameFacts& frame : run.done) {
    if (frame.judged_sunshine == kSunshine) values.push_back(SunOverSky(frame));
  }
  return PartOf(DistributionOf(values), kPart);
}

Figure ShareJudgedRight(const RunToJudge& run) {
  int right = 0;
  int judged = 0;
  for (const FrameFacts& frame : run.done) {
    if (!frame.judged_sunshine) continue;
    ++judged;
    right += ShowsSun(frame) == *frame.judged_sunshine ? 1 : 0;
  }
  return judged > 0 ? Figure(double(right) / judged) : std::nullopt;
}

Figure HardlyKnown(const RunToJudge& run) {
  return static_cast<double>(std::ranges::count(run.done, false, &FrameFacts::light_is_known));
}

// A figure over all frames with truth.
template <std::optional<Distribution> LightSummary::*kOf, double Distribution::*kPart>
Figure OfLight(const RunToJudge& run) {
  return run.score ? PartOf(run.score->light.all.*kOf, kPart) : std::nullopt;
}

// A figure over the well-posed frames, where not all are.
template <std::optional<Distribution> LightSummary::*kOf, double Distribution::*kPart>
Figure OfWellPosed(const RunToJudge& run) {
  if (!run.score || run.score->light.well_posed.frames >= run.score->light.all.frames) return {};
  return PartOf(run.score->light.well_posed.*kOf, kPart);
}

template <std::optional<Distribution> LightSummary::*kOf>
Figure MedianDegOf(const RunToJudge& run) {
  const Figure median_rad = OfLight<kOf, &Distribution::median>(run);
  return median_rad ? Figure(DegFromRad(*median_rad)) : std::nullopt;
}

template <std::optional<SigmaCoverage> LightSummary::*kOf>
Figure WithinTwoStddev(const RunToJudge& run) {
  if (!run.score || !(run.score->light.all.*kOf)) return {};
  return (run.score->light.all.*kOf)->within_2;
}

template <std::optional<Distribution> CompositeSummary::*kOf>
Figure MedianOfPictures(const RunToJudge& run) {
  return run.score ? PartOf(run.score->composite.*kOf, &Distribution::median) : std::nullopt;
}

}  // namespace

const std::vector<FigureKind>& AllFigureKinds() {
  using D = Distribution;
  using L = LightSummary;
  using C = CompositeSummary;
  // Fits and pictures differ from machine to machine in the last digits of sums over thousands of
  // floats, and where a sample is just in or just out.
  static const std::vector<FigureKind> kinds{
      {"frames_done",
       "frames done",
       true,
       0.0,
       [](const RunToJudge& run) { return Figure(run.done.size()); }},
      {"frames_failed",
       "frames failed",
       false,
       0.0,
       [](const RunToJudge& run) { return Figure(run.frames_failed); }},
      {"light_hardly_known", "frames whose light is hardly known", false, 0.0, HardlyKnown},
      {"inlier_share_median",
       "inliers among the samples, median",
       true,
       0.002,
       OfFrames<&FrameFacts::inlier_fraction, &D::median>},
      {"residual_median",
       "residual of the fit, median",
       false,
       0.0005,
       OfFrames<&FrameFacts::relative_residual, &D::median>},
      {"sky_hue_smallest",
       "smallest over largest channel of the sky, smallest",
       true,
       0.005,
       OfFrames<SkyHue, &D::smallest>},
      {"contrast_step_largest",
       "log step of 1 + sun over sky within an hour, largest",
       false,
       0.005,
       [](const RunToJudge& run) { return LargestContrastStep(run.done); }},
      {"sky_step_largest",
       "log step of the sky within an hour, largest",
       false,
       0.005,
       [](const RunToJudge& run) { return LargestSkyStep(run.done); }},
      {"sunshine_right", "frames with sun or none as a person judged", true, 0.0, ShareJudgedRight},
      {"sunless_sun_over_sky_largest",
       "sun over sky where a person saw no sun, largest",
       false,
       0.01,
       SunOverSkyWhereJudged<false, &D::largest>},
      {"sunny_sun_over_sky_smallest",
       "sun over sky where a person saw the sun, smallest",
       true,
       0.02,
       SunOverSkyWhereJudged<true, &D::smallest>},
      {"untouched_pixels_smallest",
       "camera's own pixels outside the mask, smallest",
       true,
       0.0,
       OfFrames<&FrameFacts::untouched_share, &D::smallest>},
      {"glowing_pixels",
       "real pixels twice as bright as anything around",
       false,
       0.0,
       SumOf<&FrameFacts::glowing_pixels>},
      {"clamped_pixels",
       "pixels beyond what can be written",
       false,
       0.0,
       SumOf<&FrameFacts::clamped_pixels>},
      {"sun_error_median",
       "sun error over the largest sun, median",
       false,
       0.0005,
       OfLight<&L::sun_error, &D::median>},
      {"sun_error_95th",
       "sun error, 95th percentile",
       false,
       0.001,
       OfLight<&L::sun_error, &D::percentile_95>},
      {"sky_error_median", "sky error, median", false, 0.0005, OfLight<&L::sky_error, &D::median>},
      {"sky_error_95th",
       "sky error, 95th percentile",
       false,
       0.001,
       OfLight<&L::sky_error, &D::percentile_95>},
      {"sun_to_sky_error_median",
       "error of sun over sky, median",
       false,
       0.001,
       OfLight<&L::sun_to_sky_error, &D::median>},
      {"well_posed_sun_error_median",
       "sun error, well-posed frames, median",
       false,
       0.0005,
       OfWellPosed<&L::sun_error, &D::median>},
      {"well_posed_sun_error_95th",
       "sun error, well-posed frames, 95th",
       false,
       0.001,
       OfWellPosed<&L::sun_error, &D::percentile_95>},
      {"well_posed_sky_error_median",
       "sky error, well-posed frames, median",
       false,
       0.0005,
       OfWellPosed<&L::sky_error, &D::median>},
      {"well_posed_sky_error_95th",
       "sky error, well-posed frames, 95th",
       false,
       0.001,
       OfWellPosed<&L::sky_error, &D::percentile_95>},
      {"sun_colour_angle_median_deg",
       "angle between RGB of sun and truth, median, deg",
       false,
       0.02,
       MedianDegOf<&L::sun_colour_angle_rad>},
      {"sky_colour_angle_median_deg",
       "angle between RGB of sky and truth, median, deg",
       false,
       0.02,
       MedianDegOf<&L::sky_colour_angle_rad>},
      // One value of one frame more or less.
      {"sun_within_2_stddev",
       "sun values within 2 standard deviations",
       true,
       0.02,
       WithinTwoStddev<&L::sun_sigma>},
      {"sky_within_2_stddev",
       "sky values within 2 standard deviations",
       true,
       0.02,
       WithinTwoStddev<&L::sky_sigma>},
      {"object_psnr_median_db",
       "PSNR on the object, median, dB",
       true,
       0.1,
       MedianOfPictures<&C::object_psnr_db>},
      {"object_psnr_without_mirrors_median_db",
       "PSNR on the object without glossy materials, median, dB",
       true,
       0.1,
       MedianOfPictures<&C::object_psnr_without_specular_db>},
      {"effect_psnr_median_db",
       "PSNR where it changes uncovered pixels, dB",
       true,
       0.1,
       MedianOfPictures<&C::effect_psnr_db>},
      {"similarity_median",
       "SSIM around the object and its effects, median",
       true,
       0.001,
       MedianOfPictures<&C::similarity>},
      {"wrongly_changed_median",
       "pixels changed though unchanged in truth, median",
       false,
       0.0003,
       MedianOfPictures<&C::changed_of_unchanged>}};
  return kinds;
}

std::map<std::string, double> FiguresOf(const RunToJudge& run) {
  std::map<std::string, double> figures;
  for (const FigureKind& kind : AllFigureKinds()) {
    const std::optional<double> value = kind.of(run);
    if (value && std::isfinite(*value)) figures[kind.name] = *value;
  }
  return figures;
}

void AddSeed(const std::map<std::string, double>& figures, SeededFigures& all) {
  for (const auto& [name, value] : figures) all[name].push_back(value);
}

std::string FigureComparison::Reason() const {
  if (outcome == Outcome::kGone) {
    return kind.words + ": was " + Text(*baseline) + " in the baseline, and is not there any more";
  }
  if (outcome != Outcome::kWorse) return {};
  return kind.words + ": " + Text(*now) + ", in the baseline " + Text(*baseline) +
         " with a noise of " + Text(noise) + "; expected " + Text(limit) + " or " +
         (kind.higher_is_better ? "more" : "less");
}

std::vector<FigureComparison> CompareFigures(const SeededFigures& baseline,
                                             const SeededFigures& now) {
  using Outcome = FigureComparison::Outcome;
  std::vector<FigureComparison> comparisons;
  for (const FigureKind& kind : AllFigureKinds()) {
    const auto before = baseline.find(kind.name);
    const auto after = now.find(kind.name);
    const bool was = before != baseline.end() && !before->second.empty();
    const bool is = after != now.end() && !after->second.empty();
    if (!was && !is) continue;
    FigureComparison& comparison = comparisons.emplace_back();
    comparison.kind = kind;
    if (is) comparison.now = Percentile(after->second, 0.5);
    if (!was) {
      comparison.outcome = Outcome::kNew;
      continue;
    }
    comparison.baseline = Percentile(before->second, 0.5);
    const auto [least, most] = std::minmax_element(before->second.begin(), before->second.end());
    comparison.noise = std::max(*most - *least, kind.rounding);
    const double up = kind.higher_is_better ? 1.0 : -1.0;  // Towards the better.
    const double worst = kind.higher_is_better ? *least : *most;
    const double best = kind.higher_is_better ? *most : *least;
    comparison.limit = worst - up * comparison.noise;
    if (!is) {
      comparison.outcome = Outcome::kGone;
    } else if (!(up * *comparison.now >= up * comparison.limit)) {
      comparison.outcome = Outcome::kWorse;
    } else if (up * *comparison.now > up * best + comparison.noise) {
      comparison.outcome = Outcome::kBetter;
    }
  }
  return comparisons;
}

}  // namespace pleinair
