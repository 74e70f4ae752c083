#include "estimation/internal/weather_mixture.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

#include "estimation/internal/bounded_quadratic.h"
#include "estimation/internal/square.h"
#include "estimation/internal/symmetric_algebra.h"

namespace pleinair::estimation_internal {
namespace {

// Spread of a free gain, relative to the gain that the samples determine: wide, yet a mean stays a
// mean.
constexpr double kFreeGainStddev = 1.0;

double LogDeterminant(const LightMatrix& positive) {
  return 2.0 * LowerRootOf(positive).diagonal().array().log().sum();
}

}  // namespace

// The sum (sun RGB, sky RGB) that an unknown is a part of.
int WeatherMixture::SumOf(Eigen::Index unknown) const {
  const auto basis = static_cast<int>(unknown) % basis_count_;
  const auto channel = static_cast<int>(unknown) / basis_count_;
  return has_sun_ && basis == 0 ? channel : 3 + channel;
}

void WeatherMixture::Load(const LightingPrior& prior, const FitProblem& problem) {
  has_sun_ = problem.has_sun;
  basis_count_ = problem.basis_count;
  gain_is_free_ = prior.gain_is_free;
  channel_gain_stddev_ = prior.channel_gain_stddev;
  repeats_ = prior.repeats;
  likeliest_before_ = 0;
  weathers_.clear();
  for (std::size_t w = 0; w < prior.weathers.size(); ++w) {
    const WeatherLight& given = prior.weathers[w];
    if (!(given.share > 0.0)) continue;
    Weather& weather = weathers_.emplace_back();
    weather.log_share = std::log(given.share);
    weather.last_log_evidence = given.log_evidence;
    if (w < prior.log_likelihood.size()) weather.log_likelihood = prior.log_likelihood[w];
    weather.light = given.light;
    Rescale(1.0 / problem.irradiance_unit, weather.light);
    SetInformation(weather, 1.0);
    if (weather.log_share > weathers_[likeliest_before_].log_share) {
      likeliest_before_ = weathers_.size() - 1;
    }
  }
  solutions_.assign(std::max<std::size_t>(1, weathers_.size()), {});
  for (std::size_t w = 0; w < weathers_.size(); ++w) {
    solutions_[w].share = std::exp(weathers_[w].log_share);
  }
  if (weathers_.empty()) solutions_[0].share = 1.0;
}

// The samples' evidence of a weather relative to the likeliest one, without the part that repeats
// the last picture's evidence.
double WeatherMixture::News(std::size_t weather) const {
  const double now = solutions_[weather].log_evidence - solutions_[likeliest_before_].log_evidence;
  const double before =
      weathers_[weather].last_log_evidence - weathers_[likeliest_before_].last_log_evidence;
  const double common = (now > 0.0) == (before > 0.0)
                            ? std::copysign(std::min(std::abs(now), std::abs(before)), now)
                            : 0.0;
  return now - repeats_ * common;
}

void WeatherMixture::SetInformation(Weather& weather, double gain) {
  LightGaussian light = weather.light;
  ScaleBy(gain, light);
  if (gain_is_free_) AddGainError(kFreeGainStddev, light);
  AddChannelGainError(channel_gain_stddev_, light);
  const int first = has_sun_ ? 0 : 3;
  const int count = 6 - first;
  const LightMatrix known = light.covariance.bottomRightCorner(count, count);
  weather.information.setZero();
  weather.information.bottomRightCorner(count, count) = InverseOf(known);
  weather.information_times_mean = weather.information * light.mean;
  weather.mean_square = light.mean.dot(weather.information_times_mean);
  weather.log_determinant = -LogDeterminant(known);
}

void WeatherMixture::ChooseGains(const Evidence& samples) {
  if (!gain_is_free_) return;
  for (std::size_t w = 0; w < weathers_.size(); ++w) {
    Weather& weather = weathers_[w];
    // The sky's shapes in equal parts.
    const double share = 1.0 / (basis_count_ - (has_sun_ ? 1 : 0));
    LightVector light(samples.gradient.size());
    for (Eigen::Index u = 0; u < light.size(); ++u) {
      const int sum = SumOf(u);
      light[u] = weather.light.mean[sum] * (sum < 3 ? 1.0 : share);
    }
    const double square = light.dot(samples.normal * light);
    const double projection = light.dot(samples.gradient);
    const double gain = square > 0.0 && projection > 0.0 ? projection / square : 1.0;
    solutions_[w].gain = gain;
    SetInformation(weather, gain);
  }
}

void WeatherMixture::Solve(const Evidence& evidence, Which which) {
  if (weathers_.empty()) {
    WeatherSolution& solution = solutions_[0];
    solution.light = MinimiseNonNegative(evidence.normal, evidence.gradient);
    solution.information = LightMatrix::Zero(evidence.normal.rows(), evidence.normal.cols());
    solution.information_times_mean = LightVector::Zero(evidence.gradient.size());
    return;
  }
  const Eigen::Index unknowns = evidence.gradient.size();
  const auto is_solved = [&](std::size_t w) {
    return which == Which::kAll || solutions_[w].share > kLeastShare;
  };
  for (std::size_t w = 0; w < weathers_.size(); ++w) {
    if (!is_solved(w)) continue;
    const Weather& weather = weathers_[w];
    WeatherSolution& solution = solutions_[w];
    solution.information.resize(unknowns, unknowns);
    solution.information_times_mean.resize(unknowns);
    for (Eigen::Index u = 0; u < unknowns; ++u) {
      solution.information_times_mean[u] = weather.information_times_mean[SumOf(u)];
      for (Eigen::Index v = 0; v < unknowns; ++v) {
        solution.information(u, v) = weather.information(SumOf(u), SumOf(v));
      }
    }
    const LightMatrix normal = evidence.normal + solution.information;
    const LightVector gradient = evidence.gradient + solution.information_times_mean;
    solution.light = MinimiseNonNegative(normal, gradient);
    const LightVector& x = solution.light;
    const double cost = x.dot(normal * x) - 2.0 * x.dot(gradient) + weather.mean_square;
    solution.log_evidence =
        0.5 * (weather.log_determinant - LogDeterminant(normal) - cost) + weather.log_likelihood;
  }
  std::array<double, kSkyStates> log_share{};
  double largest = -std::numeric_limits<double>::infinity();
  for (std::size_t w = 0; w < weathers_.size(); ++w) {
    log_share[w] =
        is_solved(w) ? weathers_[w].log_share + News(w) : -std::numeric_limits<double>::infinity();
    largest = std::max(largest, log_share[w]);
  }
  double sum = 0.0;
  for (std::size_t w = 0; w < weathers_.size(); ++w) {
    solutions_[w].share = std::exp(log_share[w] - largest);
    sum += solutions_[w].share;
  }
  for (WeatherSolution& solution : solutions_) solution.share /= sum;
}

bool WeatherMixture::Refine(const Evidence& evidence, CeresSolver& ceres) {
  bool settled = true;
  for (WeatherSolution& solution : solutions_) {
    if (!(solution.share > kLeastShare)) continue;
    settled = ceres.Solve(evidence.normal + solution.information,
                          evidence.gradient + solution.information_times_mean,
                          solution.light) &&
              settled;
  }
  return settled;
}

LightVector WeatherMixture::Light() const {
  LightVector light = LightVector::Zero(solutions_[0].light.size());
  double weights = 0.0;
  for (const WeatherSolution& solution : solutions_) {
    if (!(solution.share > kLeastShare)) continue;
    if (light.size() == 0) light = LightVector::Zero(solution.light.size());
    const double weight = Cube(solution.share);
    light += weight * solution.light;
    weights += weight;
  }
  return light / weights;
}

const LightMatrix& WeatherMixture::Information() const {
  return std::max_element(
             solutions_.begin(),
             solutions_.end(),
             [](const WeatherSolution& a, const WeatherSolution& b) { return a.share < b.share; })
      ->information;
}

}  // namespace pleinair::estimation_internal
