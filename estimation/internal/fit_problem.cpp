#include "estimation/internal/fit_problem.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <utility>

#include <glm/common.hpp>

#include "scene/is_finite.h"
#include "scene/upper_median.h"

namespace pleinair::estimation_internal {
namespace {

// A sample is usable when its model is; a channel of it when its radiance is, too.
bool HasModel(const DiffuseSample& sample, int sky_shapes) {
  if (!(sample.weight > 0.0) || !std::isfinite(sample.weight)) return false;
  if (!IsFinite(sample.sun_transport_rgb)) return false;
  for (int k = 0; k < sky_shapes; ++k) {
    if (!IsFinite(sample.sky_transport_rgb[static_cast<std::size_t>(k)])) return false;
  }
  return true;
}

// Of a sample that has a model.
bool ChannelHasModel(const DiffuseSample& sample, int sky_shapes, bool has_sun, int channel) {
  double response = 0.0;
  double least = has_sun ? sample.sun_transport_rgb[channel] : 0.0;
  if (has_sun) response += sample.sun_transport_rgb[channel];
  for (int k = 0; k < sky_shapes; ++k) {
    const double transport = sample.sky_transport_rgb[static_cast<std::size_t>(k)][channel];
    response += transport;
    least = std::min(least, transport);
  }
  return response > 0.0 && least >= 0.0;
}

bool ChannelIsUsable(const DiffuseSample& sample, int sky_shapes, bool has_sun, int channel) {
  const double stddev = sample.radiance_stddev_rgb[channel];
  return std::isfinite(sample.radiance_rgb[channel]) && stddev >= 0.0 && std::isfinite(stddev) &&
         ChannelHasModel(sample, sky_shapes, has_sun, channel);
}

// Bit c says that channel c is.
unsigned UsableChannels(const DiffuseSample& sample, int sky_shapes, bool has_sun) {
  unsigned usable = 0;
  if (!HasModel(sample, sky_shapes)) return usable;
  for (int channel = 0; channel < 3; ++channel) {
    if (ChannelIsUsable(sample, sky_shapes, has_sun, channel)) usable |= 1u << channel;
  }
  return usable;
}

// NaN would break the ordering; those few values decide nothing, so they count as 0.
double Ordered(double value) { return std::isnan(value) ? 0.0 : value; }

auto ValueKey(const DiffuseSample& s) {
  const auto& sky = s.sky_transport_rgb;
  return std::tuple(s.weight,
                    Ordered(s.radiance_rgb.x),
                    Ordered(s.radiance_rgb.y),
                    Ordered(s.radiance_rgb.z),
                    s.sun_transport_rgb.x,
                    s.sun_transport_rgb.y,
                    s.sun_transport_rgb.z,
                    sky[0].x,
                    sky[0].y,
                    sky[0].z);
}

bool ComesBefore(const DiffuseSample& a, const DiffuseSample& b) {
  if (a.plane != b.plane) return a.plane < b.plane;
  if (a.pixel.y != b.pixel.y) return a.pixel.y < b.pixel.y;
  if (a.pixel.x != b.pixel.x) return a.pixel.x < b.pixel.x;
  return ValueKey(a) < ValueKey(b);
}

}  // namespace

// Quarters: light between surfaces is smooth, and so is what a model of it misses. Trends take more
// cells, which show how alike neighbours are, with enough samples that their means are no chance.
const FitProblem::Division FitProblem::kForNoise{.most_cells = 4, .least_in_cell = 4};
const FitProblem::Division FitProblem::kForTrends{.most_cells = 16, .least_in_cell = 10};

void FitProblem::Load(std::span<const DiffuseSample> samples,
                      const LightingPrior& prior,
                      bool sun_is_up,
                      double exponent) {
  const int sky_shapes = prior.sky_shapes;
  const CameraErrors& camera = prior.camera;
  has_sun = sun_is_up;
  basis_count = sky_shapes + (has_sun ? 1 : 0);
  const auto possible = [](double any) {
    return std::clamp(any, -kMostResponseExponent, kMostResponseExponent);
  };
  const bool is_unknown = camera.exponent_stddev > 0.0;
  removed_exponent = is_unknown ? possible(exponent) : 0.0;
  exponent_mean =
      is_unknown ? (possible(camera.exponent) - removed_exponent) / camera.exponent_stddev : 0.0;
  // Of what differs from it: (1 + removed) (1 + other) - 1 - removed is (1 + removed) other.
  exponent_stddev = camera.exponent_stddev / (1.0 + removed_exponent);
  const auto factor_without_exponent = [&](double light) {
    return removed_exponent != 0.0 && light > 0.0
               ? std::pow(light / camera.white_radiance,
                          -removed_exponent / (1.0 + removed_exponent))
               : 1.0;
  };
  glm::dvec3 veil_rgb = camera.veil_stddev * camera.mean_radiance_rgb;
  for (int c = 0; c < 3; ++c) veil_rgb[c] *= factor_without_exponent(camera.mean_radiance_rgb[c]);
  const bool has_veil = std::max({veil_rgb.x, veil_rgb.y, veil_rgb.z}) > 0.0;
  error_count = 0;
  const auto error_of = [this](double mean, double stddev) {
    return stddev > 0.0 ? CameraError{error_count++, stddev, mean / stddev} : CameraError{};
  };
  veil = error_of(0.0, has_veil ? camera.veil_stddev : 0.0);
  vignetting = error_of(camera.vignetting, camera.vignetting_stddev);
  pattern = error_of(0.0, camera.pattern_stddev);
  saturation = error_of(camera.saturation, camera.saturation_stddev);
  if (exponent_stddev > 0.0) ++error_count;
  order_.clear();
  for (const DiffuseSample& sample : samples) {
    const unsigned channels = UsableChannels(sample, sky_shapes, has_sun);
    if (channels != 0) order_.push_back({&sample, channels});
  }
  sample_count = static_cast<int>(order_.size());
  ignored = static_cast<int>(samples.size()) - sample_count;
  const auto before = [](const Usable& a, const Usable& b) {
    return ComesBefore(*a.sample, *b.sample);
  };
  if (!std::is_sorted(order_.begin(), order_.end(), before)) {
    std::sort(order_.begin(), order_.end(), before);
  }

  const std::size_t values = order_.size() * 3;
  radiance.resize(values);
  noise.resize(values);
  weight.resize(values);
  transport.assign(values * static_cast<std::size_t>(ColumnCount()), 0.0);
  plane.resize(order_.size());
  source.resize(order_.size());
  corner_share.resize(order_.size());
  double* row = transport.data();
  plane_count = 0;
  for (std::size_t i = 0; i < order_.size(); ++i) {
    const DiffuseSample& sample = *order_[i].sample;
    if (i == 0 || sample.plane != order_[i - 1].sample->plane) ++plane_count;
    plane[i] = plane_count - 1;
    source[i] = static_cast<std::int32_t>(order_[i].sample - samples.data());
    corner_share[i] = camera.lens_circle.ShareOfCorner(glm::dvec2(sample.pixel) + 0.5);
    for (int c = 0; c < 3; ++c) {
      const bool usable = (order_[i].channels >> c & 1u) != 0;
      // A clipped channel has light, too, which the others' saturation depends on.
      const bool has_model = usable || ChannelHasModel(sample, sky_shapes, has_sun, c);
      const std::size_t v = i * 3 + static_cast<std::size_t>(c);
      radiance[v] = usable ? sample.radiance_rgb[c] : 0.0;
      noise[v] = usable ? sample.radiance_stddev_rgb[c] : 0.0;
      const double factor = factor_without_exponent(radiance[v]);
      radiance[v] *= factor;
      noise[v] *= factor / (1.0 + removed_exponent);
      weight[v] = usable ? sample.weight : 0.0;
      if (has_sun) *row++ = has_model ? sample.sun_transport_rgb[c] : 0.0;
      for (int k = 0; k < sky_shapes; ++k) {
        *row++ = has_model ? sample.sky_transport_rgb[static_cast<std::size_t>(k)][c] : 0.0;
      }
      row += error_count;
    }
  }
  FindTrends();
  if (pattern.place >= 0 || saturation.place >= 0) FillLogAlbedo();
  DivideIntoCells(kForNoise);
  ChooseUnits(prior.scale_rgb);
  white = camera.white_radiance / radiance_unit;
  if (has_veil) FillVeilColumn(veil_rgb);
}

void FitProblem::FillLogAlbedo() {
  log_albedo.assign(radiance.size(), 0.0);
  plane_over_own_albedo.assign(radiance.size(), 1.0);
  for (std::size_t first = 0; first < order_.size();) {
    std::size_t last = first;
    while (last < order_.size() && plane[last] == plane[first]) ++last;
    for (int c = 0; c < 3; ++c) {
      const auto albedo = [&](std::size_t i) { return order_[i].sample->measured_albedo_rgb[c]; };
      Mean mean;
      for (std::size_t i = first; i < last; ++i) {
        if (albedo(i) > 0.0) mean.Add(std::log(albedo(i)));
      }
      for (std::size_t i = first; i < last; ++i) {
        if (!(albedo(i) > 0.0)) continue;
        const std::size_t v = i * 3 + static_cast<std::size_t>(c);
        log_albedo[v] = std::log(albedo(i)) - mean.Value();
        plane_over_own_albedo[v] = std::exp(-log_albedo[v]);
      }
    }
    first = last;
  }
}

double FitProblem::InPicture(std::size_t v) const {
  if (removed_exponent == 0.0 || !(radiance[v] > 0.0)) return radiance[v];
  return radiance[v] * std::pow(radiance[v] / white[static_cast<int>(v % 3)], removed_exponent);
}

void FitProblem::FillVeilColumn(const glm::dvec3& veil_rgb) {
  const auto columns = static_cast<std::size_t>(ColumnCount());
  for (std::size_t v = 0; v < weight.size(); ++v) {
    const auto c = static_cast<int>(v % 3);
    if (!(weight[v] > 0.0)) continue;
    transport[v * columns + static_cast<std::size_t>(basis_count + veil.place)] =
        veil_rgb[c] / radiance_unit[c];
  }
}

void FitProblem::SetResponseColumns(std::span<const double> predicted) {
  const auto columns = static_cast<std::size_t>(ColumnCount());
  const auto set = [&](const CameraError& error, const auto& less) {
    if (error.place < 0) return;
    const auto column = static_cast<std::size_t>(basis_count + error.place);
    for (std::size_t v = 0; v < weight.size(); ++v) {
      transport[v * columns + column] =
          weight[v] > 0.0 ? -error.stddev * less(v) * predicted[v] : 0.0;
    }
  };
  set(vignetting, [this](std::size_t v) { return corner_share[v / 3]; });
  set(pattern, [this](std::size_t v) { return log_albedo[v]; });
  SetSaturationColumn(predicted);
  if (!(exponent_stddev > 0.0)) return;
  for (std::size_t v = 0; v < weight.size(); ++v) {
    transport[v * columns + columns - 1] =
        weight[v] > 0.0 && predicted[v] > 0.0
            ? exponent_stddev * predicted[v] *
                  std::log(predicted[v] / white[static_cast<int>(v % 3)])
            : 0.0;
  }
}

// In the picture's units, which the channels have in common, by the planes' mean albedos: the
// colours of a pattern that lies beside its place would seem pale. A sample without a model
// of one of the channels has no grey to compare with.
void FitProblem::SetSaturationColumn(std::span<const double> predicted) {
  if (saturation.place < 0) return;
  const auto columns = static_cast<std::size_t>(ColumnCount());
  const auto column = static_cast<std::size_t>(basis_count + saturation.place);
  for (std::size_t first = 0; first < weight.size(); first += 3) {
    double grey = 0.0;
    bool has_all = true;
    for (std::size_t c = 0; c < 3; ++c) {
      grey += predicted[first + c] * plane_over_own_albedo[first + c] *
              radiance_unit[static_cast<int>(c)] / 3.0;
      has_all = has_all && predicted[first + c] > 0.0;
    }
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t v = first + c;
      transport[v * columns + column] =
          has_all ? saturation.stddev * (predicted[v] - grey / plane_over_own_albedo[v] /
                                                            radiance_unit[static_cast<int>(c)])
                  : 0.0;
    }
  }
}

void FitProblem::DivideIntoCells(const Division& division) {
  cell.resize(order_.size());
  places_.resize(order_.size());
  plane_of_cell.clear();
  for (std::size_t first = 0; first < places_.size();) {
    std::size_t last = first;
    for (; last < places_.size() && plane[last] == plane[first]; ++last) {
      places_[last] = {order_[last].sample->pixel, static_cast<int>(last)};
    }
    Divide(plane[first], std::span(places_).subspan(first, last - first), division);
    first = last;
  }
}

double FitProblem::SunShare(std::size_t sample) const {
  double sun = 0.0;
  double sky = 0.0;
  for (int c = 0; c < 3; ++c) {
    const double* row = Transport(static_cast<int>(sample), c);
    sun += row[0];
    for (int j = 1; j < basis_count; ++j) sky += row[j];
  }
  sky /= basis_count - 1;
  return sun + sky > 0.0 ? std::clamp(sun / (sun + sky), 0.0, 1.0) : 0.0;
}

void FitProblem::FindTrends() {
  trend.assign(order_.size(), 0.0);
  if (!has_sun) return;
  DivideIntoCells(kForTrends);
  for (std::size_t i = 0; i < trend.size(); ++i) trend[i] = SunShare(i);
  cell_means_.assign(2 * plane_of_cell.size(), Mean{});
  std::size_t first_cell = 0;  // Of the plane: its cells follow each other.
  for (std::size_t first = 0; first < trend.size();) {
    std::size_t last = first;
    while (last < trend.size() && plane[last] == plane[first]) ++last;
    std::size_t last_cell = first_cell;
    while (last_cell < plane_of_cell.size() && plane_of_cell[last_cell] == plane[first]) {
      ++last_cell;
    }
    FindTrend({first, last}, {first_cell, last_cell});
    first = last;
    first_cell = last_cell;
  }
}

// From the sun's shares of a plane's samples. Only as far as neighbours are alike: what differs
// from sample to sample at random is no trend.
void FitProblem::FindTrend(const Range& samples, const Range& cells) {
  const auto group_of = [&](std::size_t i) { return order_[i].sample->is_lit ? 1u : 0u; };
  std::array<Mean, 2> means{};  // In the shade, and in the sun.
  std::array<double, 2> squares{};
  for (std::size_t i = samples.first; i < samples.last; ++i) {
    const std::size_t group = group_of(i);
    means[group].Add(trend[i]);
    squares[group] += trend[i] * trend[i];
    cell_means_[2 * static_cast<std::size_t>(cell[i]) + group].Add(trend[i]);
  }
  std::array<double, 2> factors{};
  for (std::size_t group = 0; group < 2; ++group) {
    // Less is rounding: all samples have the same responses.
    constexpr double kLeastSpread = 1e-6;
    const double mean = means[group].Value();
    const double count = means[group].count;
    const double variance = squares[group] / std::max(1.0, count) - mean * mean;
    if (!(count > 1.0) || !(variance > kLeastSpread * kLeastSpread)) continue;
    double between = 0.0;  // Share of the variance that is between the cells' means.
    double cells_with_any = 0.0;
    for (std::size_t c = cells.first; c < cells.last; ++c) {
      const Mean& in_cell = cell_means_[2 * c + group];
      if (!(in_cell.count > 0.0)) continue;
      const double apart = in_cell.Value() - mean;
      between += in_cell.count * apart * apart / (count * variance);
      cells_with_any += 1.0;
    }
    const double by_chance = (cells_with_any - 1.0) / (count - 1.0);
    const double smooth = by_chance < 1.0 ? (between - by_chance) / (1.0 - by_chance) : 0.0;
    factors[group] = 0.5 * std::sqrt(std::clamp(smooth, 0.0, 1.0) / variance);
  }
  for (std::size_t i = samples.first; i < samples.last; ++i) {
    const std::size_t group = group_of(i);
    trend[i] = factors[group] * (trend[i] - means[group].Value());
  }
}

// Halves the longer side at its median.
void FitProblem::Divide(std::int32_t in_plane, std::span<Place> places, const Division& division) {
  glm::ivec2 low = places[0].pixel;
  glm::ivec2 high = low;
  for (const Place& place : places) {
    low = glm::min(low, place.pixel);
    high = glm::max(high, place.pixel);
  }
  const glm::ivec2 size = high - low;
  if (division.most_cells < 2 || places.size() < 2 * division.least_in_cell ||
      size == glm::ivec2(0)) {
    const auto id = static_cast<std::int32_t>(plane_of_cell.size());
    for (const Place& place : places) cell[static_cast<std::size_t>(place.sample)] = id;
    plane_of_cell.push_back(in_plane);
    return;
  }
  const int axis = size.y > size.x ? 1 : 0;
  const std::size_t half = places.size() / 2;
  std::nth_element(places.begin(),
                   places.begin() + static_cast<std::ptrdiff_t>(half),
                   places.end(),
                   [axis](const Place& a, const Place& b) {
                     return std::pair(a.pixel[axis], a.sample) < std::pair(b.pixel[axis], b.sample);
                   });
  const Division halved{division.most_cells / 2, division.least_in_cell};
  Divide(in_plane, places.first(half), halved);
  Divide(in_plane, places.subspan(half), halved);
}

void FitProblem::ChooseUnits(const glm::dvec3& usual_irradiance_rgb) {
  // The light's median is what the noise floor is a share of; the response's need not be exact.
  constexpr int kEnough = 100;
  const int few = std::max(1, sample_count / kEnough);
  for (int c = 0; c < 3; ++c) {
    const auto median_over_samples = [&](int stride, auto&& value) {
      scratch_.clear();
      for (int i = 0; i < sample_count; i += stride) {
        if (weight[static_cast<std::size_t>(i * 3 + c)] > 0.0) scratch_.push_back(value(i));
      }
      return scratch_.empty() ? 0.0 : UpperMedianInPlace(scratch_);
    };
    double light = median_over_samples(
        1, [&](int i) { return radiance[static_cast<std::size_t>(i * 3 + c)]; });
    const double response = median_over_samples(few, [&](int i) {
      const double* row = Transport(i, c);
      double sum = 0.0;
      for (int j = 0; j < basis_count; ++j) sum += row[j];
      return sum;
    });
    // A channel of darkness: its own size says nothing, so that of all its samples together does,
    // and after that the prior's; the answer does not depend on which.
    if (!(light > 0.0)) {
      light = 0.0;
      for (int i = 0; i < sample_count; ++i) {
        light = std::max(light, std::abs(radiance[static_cast<std::size_t>(i * 3 + c)]));
      }
    }
    double irradiance = response > 0.0 ? light / response : 0.0;
    if (!(irradiance > 0.0)) {
      irradiance = usual_irradiance_rgb[c] > 0.0 ? usual_irradiance_rgb[c] : 1.0;
      light = response > 0.0 ? irradiance * response : 1.0;
    }
    radiance_unit[c] = light;
    irradiance_unit[c] = irradiance;
    const double transport_scale = irradiance / light;
    const double per_light = 1.0 / light;
    for (int i = 0; i < sample_count; ++i) {
      const std::size_t v = static_cast<std::size_t>(i * 3 + c);
      radiance[v] *= per_light;
      noise[v] *= per_light;
      for (int j = 0; j < basis_count; ++j) {
        transport[v * static_cast<std::size_t>(ColumnCount()) + static_cast<std::size_t>(j)] *=
            transport_scale;
      }
    }
  }
}

}  // namespace pleinair::estimation_internal
