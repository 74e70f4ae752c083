#include "estimation/lighting_filter.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

#include "estimation/internal/seconds_between.h"
#include "estimation/internal/square.h"
#include "estimation/light_component.h"
#include "scene/is_finite.h"
#include "scene/upper_median.h"

namespace pleinair {
namespace {

using estimation_internal::SecondsBetween;
using estimation_internal::Square;

constexpr int kLateFramesToStartAnew = 3;
// A run this short has not yet shown that it is more than noise or a ramp's passing value: it holds
// nothing back.
constexpr int kFramesThatHold = 3;

// Number of second differences that are kept: a step spoils two of them, a glitch three.
constexpr std::size_t kMostRoughness = 32;
// The median of chi^2 over its degrees of freedom: 0.455 for one, 0.79 for three. Channels err
// partly together.
constexpr double kMedianRoughness = 0.6;
// Before the data have spoken, counting as some of them: of a stated deviation a third is noise.
constexpr double kExpectedNoiseShare = 0.3;
constexpr int kExpectedNoiseCount = 4;
// A misfit of at most this multiple of the median is usual: in the test of a camera that looks
// about a courtyard, misfits scatter by 5 %.
constexpr double kUsualScatter = 1.2;
// Deviation of a light, as a share of it, over the unusual part of the misfit. In the same test,
// frames that are blurred over 27 pixels or posed 1 or 3 deg off have 0.1 to 0.4.
constexpr double kDeviationOfMisfit = 0.3;
// A larger misfit does not make a frame blind to a cloud.
constexpr double kMostMisfit = 0.2;
// A frame fits far worse than others by this factor of the misfit, and where it is not trusted. The
// usual scatter is far below it; a covered lens or a pose 15 deg off has 15 times as much and more.
constexpr double kFarWorse = 2.0;
// Steadier than that is a made-up stream, whose every rounding would be a change.
constexpr double kLeastNoiseShare = 0.02;

// Share of the entire light: differences that are not visible, and the deviation of a light without
// a stated one.
constexpr double kNegligible = 1e-4;
constexpr double kUnstatedDeviation = 0.05;

// The deviations by which a step may differ from what is seen of it.
constexpr double kSeenSigmas = 2.0;

// Not IsFinite: that would hide the one for vectors here.
bool HasFiniteValues(const Lighting& lighting) {
  if (!IsFinite(lighting.sun.irradiance_rgb)) return false;
  for (const SkyComponent& component : lighting.sky) {
    if (!IsFinite(component.irradiance_rgb)) return false;
  }
  return std::all_of(lighting.covariance.begin(), lighting.covariance.end(), [](double value) {
    return std::isfinite(value);
  });
}

// Variance of the sum over the basis lights of factor * irradiance, with the factor `sun` for the
// sun and `sky` for each shape of the sky.
double VarianceOf(const Lighting& lighting, int channel, double sun, double sky) {
  const std::size_t side = SideOf(lighting);
  double variance = 0.0;
  for (auto u = static_cast<std::size_t>(channel); u < side; u += 3) {
    for (auto v = static_cast<std::size_t>(channel); v < side; v += 3) {
      variance += (u < 3 ? sun : sky) * (v < 3 ? sun : sky) * lighting.covariance[u * side + v];
    }
  }
  return std::max(0.0, variance);
}

bool SameShapes(const Lighting& a, const Lighting& b) {
  return std::equal(
      a.sky.begin(),
      a.sky.end(),
      b.sky.begin(),
      b.sky.end(),
      [](const SkyComponent& x, const SkyComponent& y) { return x.shape == y.shape; });
}

// A held light may prove to have changed: the difference is a deviation.
void AddDoubt(const Lighting& raw, FilteredLighting& result) {
  Lighting& lighting = result.lighting;
  if (!HasCovariance(lighting)) return;
  const std::size_t side = SideOf(lighting);
  const std::size_t begin = result.sun.held ? 0 : 3;
  const std::size_t end = result.sky.held ? side : 3;
  for (std::size_t u = begin; u < end; ++u) {
    for (std::size_t v = begin; v < end; ++v) {
      lighting.covariance[u * side + v] += (Component(raw, u) - Component(lighting, u)) *
                                           (Component(raw, v) - Component(lighting, v));
    }
  }
}

}  // namespace

void LightingFilterOptions::Validate() const {
  const auto refuse = [](const char* field, double value, const char* expected) {
    throw std::invalid_argument(std::string("LightingFilterOptions::") + field + " is " +
                                std::to_string(value) + ": expected " + expected);
  };
  if (!(memory_s > 0.0) || !std::isfinite(memory_s)) {
    refuse("memory_s", memory_s, "a number above 0");
  }
  if (most_frames < 1) refuse("most_frames", most_frames, "at least 1");
  if (!(change_sigmas > 0.0) || !std::isfinite(change_sigmas)) {
    refuse("change_sigmas", change_sigmas, "a number above 0");
  }
}

LightingFilter::LightingFilter(const LightingFilterOptions& options) : options_(options) {
  options_.Validate();
}

FilteredLighting LightingFilter::Apply(const Lighting& raw, LightUnits units, const FrameFit& fit) {
  if (!HasFiniteValues(raw)) {
    since_last_entry_.reset();
    return {raw, {}, {}};
  }
  if (!entries_.empty() && Continues(raw, units)) {
    since_last_entry_ =
        SumOf(since_last_entry_, SeenStepsOf(fit.change, units_, SunToHorizontal(raw)));
    const double elapsed_s = SecondsBetween(last_time_, raw.time);
    if (elapsed_s < 0.0 && ++late_frames_ < kLateFramesToStartAnew) return {raw, {}, {}};
    if (elapsed_s < 0.0) Restart(units);
  } else {
    Restart(units);
  }
  late_frames_ = 0;
  last_time_ = raw.time;
  DropOldEntries(raw.time);
  Entry frame = EntryOf(raw, fit);
  const double usual = entries_.size() >= kFramesThatHold ? MedianMisfit(entries_.size()) : 0.0;
  const bool fits_far_worse = frame.misfit > fit.trusted_misfit && frame.misfit > kFarWorse * usual;
  if (usual > 0.0 && fits_far_worse && HasRuns()) {
    FilteredLighting held = Report(frame, true);
    fading_.Add(units_, {}, held.lighting, frame.lighting);
    return held;
  }
  entries_.push_back(std::move(frame));
  since_last_entry_.emplace();
  usual_misfit_ = entries_.size() > kFramesThatHold ? MedianMisfit(entries_.size() - 1) : 0.0;
  std::array<RunEnding, 2> endings;
  for (const std::size_t light : {kSun, kSky}) {
    UpdateNoise(light);
    Track& track = tracks_[light];
    track.noise_share = NoiseShare(light);
    const Span last_run{track.begin, entries_.size() - (track.pending ? 2 : 1)};
    UpdateRun(light);
    if (track.begin == last_run.begin) continue;
    endings[light] = {true, ChangeBetween(light, last_run, {track.begin, EndOfRun(light)})};
  }
  FilteredLighting result = Report(entries_.back(), false);
  fading_.Add(units_, endings, result.lighting, entries_.back().lighting);
  return result;
}

bool LightingFilter::Continues(const Lighting& raw, LightUnits units) const {
  const Lighting& last = entries_.back().lighting;
  return units == units_ && SameShapes(raw, last) && HasCovariance(raw) == HasCovariance(last) &&
         std::abs(SecondsBetween(last.time, raw.time)) <= options_.memory_s;
}

void LightingFilter::Restart(LightUnits units) {
  units_ = units;
  late_frames_ = 0;
  since_last_entry_.emplace();
  entries_.clear();
  tracks_ = {};
  fading_ = {};
}

void LightingFilter::DropOldEntries(UtcTime now) {
  while (!entries_.empty() &&
         (SecondsBetween(entries_.front().lighting.time, now) > options_.memory_s ||
          entries_.size() >= static_cast<std::size_t>(options_.most_frames))) {
    entries_.pop_front();
    for (Track& track : tracks_) track.begin -= track.begin > 0 ? 1 : 0;
  }
}

LightingFilter::Entry LightingFilter::EntryOf(const Lighting& raw, const FrameFit& fit) const {
  Entry entry;
  entry.lighting = raw;
  entry.since_last = since_last_entry_;
  entry.misfit = std::isfinite(fit.misfit) ? fit.misfit : 0.0;
  const glm::dvec3 sun = raw.sun.irradiance_rgb;
  const glm::dvec3 sky = raw.SkyIrradianceRgb();
  const double sun_to_horizontal = SunToHorizontal(raw);
  const double level = MeanOf(sun) + MeanOf(sky);
  entry.unit = UnitOf(raw, units_);
  for (int c = 0; c < 3; ++c) {
    const double unit = entry.unit[c];
    const double share_of_sun = units_ == LightUnits::kRelativePerFrame ? sun[c] / unit : 0.0;
    const double share_of_sky = units_ == LightUnits::kRelativePerFrame ? sky[c] / unit : 0.0;
    const double least = kNegligible * level / unit;
    for (const std::size_t light : {kSun, kSky}) {
      Reading& reading = entry.readings[light];
      reading.value[c] = (light == kSun ? sun[c] : sky[c]) / unit;
      double variance =
          kUnstatedDeviation * kUnstatedDeviation * reading.value[c] * reading.value[c];
      if (HasCovariance(raw)) {
        // d(share) = (d(light) - share d(total)) / total.
        variance = light == kSun
                       ? VarianceOf(raw, c, 1.0 - share_of_sun * sun_to_horizontal, -share_of_sun)
                       : VarianceOf(raw, c, -share_of_sky * sun_to_horizontal, 1.0 - share_of_sky);
        variance /= unit * unit;
      }
      reading.variance[c] = variance + least * least;
    }
  }
  return entry;
}

void LightingFilter::UpdateNoise(std::size_t light) {
  const std::size_t count = entries_.size();
  if (count < 3) return;
  const Reading& first = entries_[count - 3].readings[light];
  const Reading& second = entries_[count - 2].readings[light];
  const Reading& third = entries_[count - 1].readings[light];
  double sum = 0.0;
  for (int c = 0; c < 3; ++c) {
    const double difference = first.value[c] - 2.0 * second.value[c] + third.value[c];
    const double stated = first.variance[c] + 4.0 * second.variance[c] + third.variance[c];
    if (stated > 0.0) sum += difference * difference / stated;
  }
  std::deque<double>& roughness = tracks_[light].roughness;
  roughness.push_back(sum / 3.0);
  if (roughness.size() > kMostRoughness) roughness.pop_front();
}

double LightingFilter::NoiseShare(std::size_t light) const {
  const std::deque<double>& roughness = tracks_[light].roughness;
  std::vector<double> values(roughness.begin(), roughness.end());
  values.insert(values.end(),
                kExpectedNoiseCount,
                kMedianRoughness * kExpectedNoiseShare * kExpectedNoiseShare);
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  // The stated deviation is that of the whole error: what exceeds it is light.
  return std::clamp(std::sqrt(*middle / kMedianRoughness), kLeastNoiseShare, 1.0);
}

// Of the first `entries`; 0: there are none.
double LightingFilter::MedianMisfit(std::size_t entries) const {
  if (entries == 0) return 0.0;
  std::vector<double> misfits;
  misfits.reserve(entries);
  for (std::size_t i = 0; i < entries; ++i) misfits.push_back(entries_[i].misfit);
  return UpperMedianInPlace(misfits);
}

LightingFilter::Noise LightingFilter::NoiseOf(std::size_t light, std::size_t entry) const {
  const Reading& reading = entries_[entry].readings[light];
  const double share = tracks_[light].noise_share;
  Noise noise{share * share * reading.variance, glm::dvec3(0.0)};
  const double misfit = std::min(entries_[entry].misfit, kMostMisfit);
  if (usual_misfit_ > 0.0 && misfit > kUsualScatter * usual_misfit_) {
    const glm::dvec3 deviation = kDeviationOfMisfit * reading.value;
    noise.excess = (misfit * misfit - usual_misfit_ * usual_misfit_) * deviation * deviation;
  }
  return noise;
}

double LightingFilter::WeightOf(std::size_t light, std::size_t entry) const {
  const Noise noise = NoiseOf(light, entry);
  const double variance = MeanOf(noise.usual + noise.excess);
  // Without any light all frames are equal.
  return entries_[entry].readings[light].left_out ? 0.0 : variance > 0.0 ? 1.0 / variance : 1.0;
}

LightingFilter::Mean LightingFilter::MeanOver(std::size_t light,
                                              std::size_t begin,
                                              std::size_t end) const {
  Mean mean;
  double weights = 0.0;
  glm::dvec3 excess(0.0);
  for (std::size_t i = begin; i < end; ++i) {
    const Reading& reading = entries_[i].readings[light];
    const double weight = WeightOf(light, i);
    if (!(weight > 0.0)) continue;
    const Noise noise = NoiseOf(light, i);
    mean.value += weight * reading.value;
    mean.variance += weight * weight * noise.usual;
    // Frames that are wrong in the same way, one after another, are no better than one of them.
    excess += weight * glm::sqrt(noise.excess);
    weights += weight;
    ++mean.frames;
  }
  if (weights > 0.0) {
    mean.value /= weights;
    mean.variance = (mean.variance + excess * excess) / (weights * weights);
  }
  return mean;
}

bool LightingFilter::Differ(const Mean& a, const Mean& b, double* sigmas) const {
  double sum = 0.0;
  for (int c = 0; c < 3; ++c) {
    const double difference = a.value[c] - b.value[c];
    const double variance = a.variance[c] + b.variance[c];
    if (variance > 0.0) sum += difference * difference / variance;
  }
  const double in_sigmas = std::sqrt(sum / 3.0);
  if (sigmas != nullptr) *sigmas = in_sigmas;
  return in_sigmas > options_.change_sigmas;
}

std::optional<SeenStep> LightingFilter::ChangeBetween(std::size_t light,
                                                      const Span& from,
                                                      const Span& to) const {
  glm::dvec3 since_first(0.0);
  glm::dvec3 variance(0.0);
  glm::dvec3 at_from(0.0);
  glm::dvec3 at_to(0.0);
  double from_weights = 0.0;
  double to_weights = 0.0;
  for (std::size_t i = from.begin; i < to.end; ++i) {
    if (i > from.begin) {
      if (!entries_[i].since_last) return std::nullopt;
      const SeenStep& step = (*entries_[i].since_last)[light];
      since_first += step.value;
      variance = glm::max(variance, step.variance);
    }
    const double weight = WeightOf(light, i);
    if (i < from.end) {
      at_from += weight * since_first;
      from_weights += weight;
    }
    if (i >= to.begin) {
      at_to += weight * since_first;
      to_weights += weight;
    }
  }
  if (!(from_weights > 0.0) || !(to_weights > 0.0)) return std::nullopt;
  return SeenStep{at_to / to_weights - at_from / from_weights, variance};
}

// The entry's step is no glitch where the surfaces that it has in common with the run show it.
bool LightingFilter::IsSeenToChange(std::size_t light, const Span& run, std::size_t entry) const {
  const std::optional<SeenStep> seen = ChangeBetween(light, run, {entry, entry + 1});
  if (!seen || (*entries_[entry].since_last)[light].may_be_exposure) return false;
  const glm::dvec3 found =
      MeanOver(light, entry, entry + 1).value - MeanOver(light, run.begin, run.end).value;
  const double variance = Square(kSeenSigmas) * 3.0 * MeanOf(seen->variance);
  const double size = glm::dot(seen->value, seen->value);
  const glm::dvec3 apart = found - seen->value;
  return size > variance && glm::dot(apart, apart) < Square(kSeenAgreement) * size + variance;
}

void LightingFilter::UpdateRun(std::size_t light) {
  Track& track = tracks_[light];
  const std::size_t newest = entries_.size() - 1;
  if (newest == 0) {
    track.begin = 0;
    track.pending = false;
    return;
  }
  const std::size_t run_end = track.pending ? newest - 1 : newest;
  // All that the run had may have been forgotten.
  const Mean run = MeanOver(light, track.begin, run_end);
  const Mean own = MeanOver(light, newest, newest + 1);
  if (run.frames > 0 && !Differ(run, own)) {
    if (track.pending) entries_[newest - 1].readings[light].left_out = true;
    track.pending = false;
    CutWhereItChanged(light);
    return;
  }
  const bool as_before = !Differ(MeanOver(light, newest - 1, newest), own);
  if (track.pending || as_before || run.frames < kFramesThatHold ||
      IsSeenToChange(light, {track.begin, run_end}, newest)) {
    track.begin = as_before ? newest - 1 : newest;
    track.pending = false;
    return;
  }
  track.pending = true;
}

// Where the newest frames of a run differ from the ones before, these are dropped.
void LightingFilter::CutWhereItChanged(std::size_t light) {
  Track& track = tracks_[light];
  const std::size_t end = entries_.size();
  double most = options_.change_sigmas;
  std::size_t cut = track.begin;
  // The last 2, 3, 4, 5, 6, 8, 10, 13, ... frames: a change between two of these lengths is visible
  // with both.
  for (std::size_t tail = 2; track.begin + tail < end; tail += std::max<std::size_t>(1, tail / 3)) {
    double sigmas = 0.0;
    const Mean before = MeanOver(light, track.begin, end - tail);
    const Mean after = MeanOver(light, end - tail, end);
    if (before.frames == 0 || after.frames == 0) continue;
    Differ(before, after, &sigmas);
    if (sigmas > most) {
      most = sigmas;
      cut = end - tail;
    }
  }
  track.begin = cut;
}

std::size_t LightingFilter::EndOfRun(std::size_t light) const {
  return entries_.size() - (tracks_[light].pending ? 1 : 0);
}

bool LightingFilter::IsInRun(std::size_t light, std::size_t entry) const {
  const Track& track = tracks_[light];
  return entry >= track.begin && entry < EndOfRun(light) &&
         !entries_[entry].readings[light].left_out;
}

bool LightingFilter::HasRuns() const {
  return MeanOver(kSun, tracks_[kSun].begin, EndOfRun(kSun)).frames > 0 &&
         MeanOver(kSky, tracks_[kSky].begin, EndOfRun(kSky)).frames > 0;
}

FilteredLighting LightingFilter::Report(const Entry& frame, bool is_held) const {
  FilteredLighting result{frame.lighting, {}, {}};
  Lighting& lighting = result.lighting;
  const std::size_t side = SideOf(lighting);
  for (std::size_t u = 0; u < side; ++u) Component(lighting, u) = 0.0;
  std::fill(lighting.covariance.begin(), lighting.covariance.end(), 0.0);

  std::array<double, 2> weights{};
  for (const std::size_t light : {kSun, kSky}) {
    FilterSpan& span = light == kSun ? result.sun : result.sky;
    span = {0, is_held || tracks_[light].pending};
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      if (!IsInRun(light, i)) continue;
      weights[light] += WeightOf(light, i);
      ++span.frames;
    }
  }
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const Entry& entry = entries_[i];
    std::array<double, 2> share{};
    for (const std::size_t light : {kSun, kSky}) {
      if (IsInRun(light, i)) share[light] = WeightOf(light, i) / weights[light];
    }
    if (share[kSun] + share[kSky] <= 0.0) continue;
    const std::array<double, 2> root{std::sqrt(share[kSun]), std::sqrt(share[kSky])};
    const glm::dvec3 unit = frame.unit / entry.unit;
    for (std::size_t u = 0; u < side; ++u) {
      const std::size_t light_u = u < 3 ? kSun : kSky;
      const double unit_u = unit[static_cast<int>(u % 3)];
      Component(lighting, u) += share[light_u] * unit_u * Component(entry.lighting, u);
      if (!HasCovariance(lighting)) continue;
      // D R D with D the roots of the shares: the shares themselves on the sun's and the sky's own
      // parts, and never indefinite.
      for (std::size_t v = 0; v < side; ++v) {
        lighting.covariance[u * side + v] += root[light_u] * root[v < 3 ? kSun : kSky] * unit_u *
                                             unit[static_cast<int>(v % 3)] *
                                             entry.lighting.covariance[u * side + v];
      }
    }
  }
  if (units_ == LightUnits::kRelativePerFrame) GiveTotalOf(frame.lighting, lighting);
  AddDoubt(frame.lighting, result);
  return result;
}

}  // namespace pleinair
