#include "pipeline/regression.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "datasets/statistics.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

std::string Text(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.4g", value);
  return text;
}

class Figures {
 public:
  void Add(const char* name, const std::optional<double>& value, double unit = 1.0) {
    if (value && std::isfinite(*value)) by_name_[name] = unit * *value;
  }
  void AddMedian(const char* name, const std::optional<Distribution>& of, double unit = 1.0) {
    if (of) Add(name, of->median, unit);
  }
  void AddPercentile95(const char* name, const std::optional<Distribution>& of) {
    if (of) Add(name, of->percentile_95);
  }
  std::map<std::string, double> Take() { return std::move(by_name_); }

 private:
  std::map<std::string, double> by_name_;
};

void AddTruth(const Score& score, Figures& figures) {
  const LightSummary& all = score.light.all;
  figures.AddMedian("sun_error_median", all.sun_error);
  figures.AddPercentile95("sun_error_95th", all.sun_error);
  figures.AddMedian("sky_error_median", all.sky_error);
  figures.AddPercentile95("sky_error_95th", all.sky_error);
  figures.AddMedian("sun_to_sky_error_median", all.sun_to_sky_error);
  if (const LightSummary& well_posed = score.light.well_posed; well_posed.frames < all.frames) {
    figures.AddMedian("well_posed_sun_error_median", well_posed.sun_error);
    figures.AddPercentile95("well_posed_sun_error_95th", well_posed.sun_error);
    figures.AddMedian("well_posed_sky_error_median", well_posed.sky_error);
    figures.AddPercentile95("well_posed_sky_error_95th", well_posed.sky_error);
  }
  figures.AddMedian("sun_colour_angle_median_deg", all.sun_colour_angle_rad, DegFromRad(1.0));
  figures.AddMedian("sky_colour_angle_median_deg", all.sky_colour_angle_rad, DegFromRad(1.0));
  if (all.sun_sigma) figures.Add("sun_within_2_stddev", all.sun_sigma->within_2);
  if (all.sky_sigma) figures.Add("sky_within_2_stddev", all.sky_sigma->within_2);
  const CompositeSummary& composite = score.composite;
  figures.AddMedian("object_psnr_median_db", composite.object_psnr_db);
  figures.AddMedian("object_psnr_without_mirrors_median_db",
                    composite.object_psnr_without_specular_db);
  figures.AddMedian("effect_psnr_median_db", composite.effect_psnr_db);
  figures.AddMedian("similarity_median", composite.similarity);
  figures.AddMedian("wrongly_changed_median", composite.changed_of_unchanged);
}

}  // namespace

const std::vector<FigureKind>& AllFigureKinds() {
  // Fits and pictures differ from machine to machine in the last digits of sums over thousands of
  // floats, and where a sample is just in or just out.
  static const std::vector<FigureKind> kinds{
      {"frames_done", "frames done", true, 0.0},
      {"inlier_share_median", "inliers among the samples, median", true, 0.002},
      {"residual_median", "residual of the fit, median", false, 0.0005},
      {"untouched_pixels_smallest", "camera's own pixels outside the mask, smallest", true, 0.0},
      {"sun_error_median", "sun error over the largest sun, median", false, 0.0005},
      {"sun_error_95th", "sun error, 95th percentile", false, 0.001},
      {"sky_error_median", "sky error, median", false, 0.0005},
      {"sky_error_95th", "sky error, 95th percentile", false, 0.001},
      {"sun_to_sky_error_median", "error of sun over sky, median", false, 0.001},
      {"well_posed_sun_error_median", "sun error, well-posed frames, median", false, 0.0005},
      {"well_posed_sun_error_95th", "sun error, well-posed frames, 95th", false, 0.001},
      {"well_posed_sky_error_median", "sky error, well-posed frames, median", false, 0.0005},
      {"well_posed_sky_error_95th", "sky error, well-posed frames, 95th", false, 0.001},
      {"sun_colour_angle_median_deg",
       "angle between RGB of sun and truth, median, deg",
       false,
       0.02},
      {"sky_colour_angle_median_deg",
       "angle between RGB of sky and truth, median, deg",
       false,
       0.02},
      // One value of one frame more or less.
      {"sun_within_2_stddev", "sun values within 2 standard deviations", true, 0.02},
      {"sky_within_2_stddev", "sky values within 2 standard deviations", true, 0.02},
      {"object_psnr_median_db", "PSNR on the object, median, dB", true, 0.1},
      {"object_psnr_without_mirrors_median_db",
       "PSNR on the object without mirroring materials, median, dB",
       true,
       0.1},
      {"effect_psnr_median_db", "PSNR where it changes what it does not cover, dB", true, 0.1},
      {"similarity_median", "SSIM around the object and its effects, median", true, 0.001},
      {"wrongly_changed_median",
       "pixels changed though unchanged in truth, median",
       false,
       0.0003}};
  return kinds;
}

std::map<std::string, double> FiguresOf(const RunFacts& facts, const Score* score) {
  Figures figures;
  figures.Add("frames_done", facts.frames_done);
  figures.AddMedian("inlier_share_median", DistributionOf(facts.inlier_fraction));
  figures.AddMedian("residual_median", DistributionOf(facts.relative_residual));
  if (const auto untouched = DistributionOf(facts.untouched_pixels)) {
    figures.Add("untouched_pixels_smallest", untouched->smallest);
  }
  if (score != nullptr) AddTruth(*score, figures);
  return figures.Take();
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
