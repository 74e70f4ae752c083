#include "estimation/internal/reweighting.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "estimation/internal/missing_sun.h"
#include "estimation/internal/square.h"

namespace pleinair::estimation_internal {
namespace {

// Calls `loops` with the number of a sample's columns as its template argument.
template <class Loops>
void WithColumns(int column_count, Loops&& loops) {
  [&]<int... k>(std::integer_sequence<int, k...>) {
    const bool is_done =
        ((column_count == k + 1 && (loops.template operator()<k + 1>(), true)) || ...);
    static_cast<void>(is_done);
  }
  (std::make_integer_sequence<int, kMaxColumns>());
}

}  // namespace

double Reweighting::ShadeFrom() const {
  static const double kTwoLogOdds = 2.0 * std::log((1.0 - kShadeTheMeshLacks) / kShadeTheMeshLacks);
  return kTwoLogOdds * own_variance_;
}

void Reweighting::Restart() {
  for (BasisMatrix& normal : last_normal_) normal.resize(0, 0);
  own_variance_ = 0.0;
}

void Reweighting::Update(FitProblem& problem,
                         const LightGuess& guess,
                         const LightMatrix& prior_information,
                         const LightingFitOptions& options,
                         bool rescale) {
  rescale = rescale && problem.sample_count > 0;
  const bool just_explained = explained_.size() == guess.x.size() && explained_ == guess.x;
  explained_.resize(0);
  if (!just_explained) Standardise(problem, guess, options);
  if (rescale && !just_explained) EstimateScale(problem, options);
  Weigh(options);
  WithColumns(problem.ColumnCount(), [&]<int kColumns>() { Accumulate<kColumns>(problem); });
  if (rescale) {
    EstimateSlope(options);
    EstimateNoise(problem, options);
    EstimateSharedErrors(problem, prior_information, options);
  }
  FinishNormal(problem);
  last_normal_ = normal_;
}

bool Reweighting::Explains(FitProblem& problem,
                           const LightGuess& guess,
                           const LightingFitOptions& options) {
  if (weight_.empty() || problem.sample_count == 0) return false;
  // The share of samples that noise moves across the cut from one frame of a still scene to the
  // next. A new sun moves more: all lit samples.
  constexpr double kFewer = 0.01;
  const double last = InlierFraction();
  Standardise(problem, guess, options);
  const double cut = options.tukey_width * scale_;
  const double shade_from = ShadeFrom();
  int inliers = 0;
  for (std::size_t i = 0; i < deviation_.size(); ++i) {
    inliers += deviation_[i] < cut && !(shade_[i] > shade_from) ? 1 : 0;
  }
  if (static_cast<double>(inliers) < (last - kFewer) * static_cast<double>(deviation_.size())) {
    return false;
  }
  // Where the model errs much the cut is wide, and many a light is inside it.
  constexpr double kWider = 1.1;
  const double last_scale = scale_;
  EstimateScale(problem, options);
  explained_ = guess.x;
  return scale_ <= kWider * last_scale;
}

void Reweighting::Standardise(FitProblem& problem,
                              const LightGuess& guess,
                              const LightingFitOptions& options) {
  const NoiseUnits noise(options);
  const auto count = static_cast<std::size_t>(problem.sample_count);
  inverse_unit_.resize(count * 3);
  residual_.resize(count * 3);
  sky_share_.resize(count * 3);
  deviation_.resize(count);
  shade_.resize(count);
  WithColumns(problem.ColumnCount(), [&]<int kColumns>() { Predict<kColumns>(problem, guess.x); });
  problem.SetResponseColumns(residual_);
  const auto columns = static_cast<std::size_t>(problem.ColumnCount());
  const auto errors = static_cast<std::size_t>(problem.error_count);
  // Roots and quotients cost the most: several at a time.
  for (std::size_t v = 0; v < 3 * count; ++v) {
    const double predicted = residual_[v];
    const double inverse_unit =
        std::sqrt(noise.InverseSquare(predicted, problem.noise[v], problem.weight[v]));
    inverse_unit_[v] = inverse_unit;
    residual_[v] = (problem.radiance[v] - predicted) * inverse_unit;
    sky_share_[v] *= inverse_unit;
  }
  for (std::size_t e = 0; e < errors; ++e) {
    const double error = guess.camera_errors[static_cast<Eigen::Index>(e)];
    const std::size_t column = columns - errors + e;
    for (std::size_t v = 0; v < 3 * count; ++v) {
      residual_[v] -= error * problem.transport[v * columns + column] * inverse_unit_[v];
    }
  }
  const bool leave_out = options.loss == LightingFitOptions::Loss::kTukey;
  for (std::size_t i = 0; i < count; ++i) {
    double sum = 0.0;
    double residual = 0.0;
    double sky = 0.0;
    double sun = 0.0;
    double channels = 0.0;
    for (std::size_t v = i * 3; v < i * 3 + 3; ++v) {
      sum += Square(residual_[v]);
      residual += residual_[v];
      sky += sky_share_[v];
      sun += problem.radiance[v] * inverse_unit_[v] - residual_[v] - sky_share_[v];
      channels += problem.weight[v] > 0.0 ? 1.0 : 0.0;
    }
    deviation_[i] = std::sqrt(sum / channels);
    const bool may_be = leave_out && sun > kLitFrom * (sun + sky);
    shade_[i] = may_be ? -sun * (2.0 * residual + sun) / Square(channels) : 0.0;
  }
}

// Writes the light of `x` into residual_, and the sky's part of it into sky_share_.
template <int kColumns>
void Reweighting::Predict(const FitProblem& problem, const LightVector& x) {
  // The camera's errors are no light.
  std::array<double, 3 * kColumns> lights{};
  for (int c = 0; c < 3; ++c) {
    for (int j = 0; j < problem.basis_count; ++j) {
      lights[static_cast<std::size_t>(c * kColumns + j)] = x[c * problem.basis_count + j];
    }
  }
  const double* row = problem.transport.data();
  for (std::size_t v = 0; v < residual_.size(); ++v, row += kColumns) {
    const double* light = lights.data() + v % 3 * kColumns;
    double predicted = 0.0;
    for (int j = 0; j < kColumns; ++j) predicted += row[j] * light[j];
    residual_[v] = predicted;
    sky_share_[v] = problem.has_sun ? predicted - row[0] * light[0] : predicted;
  }
}

void Reweighting::Weigh(const LightingFitOptions& options) {
  const double shade_from = ShadeFrom();
  weight_.resize(deviation_.size());
  const auto weigh = [&](const auto& weight_of) {
    for (std::size_t i = 0; i < weight_.size(); ++i) weight_[i] = weight_of(deviation_[i]);
  };
  switch (options.loss) {
    case LightingFitOptions::Loss::kTukey:
      weigh([inverse_cut = 1.0 / (options.tukey_width * scale_)](double deviation) {
        return Square(std::max(0.0, 1.0 - Square(deviation * inverse_cut)));
      });
      for (std::size_t i = 0; i < weight_.size(); ++i) {
        weight_[i] = shade_[i] > shade_from ? 0.0 : weight_[i];
      }
      break;
    case LightingFitOptions::Loss::kHuber:
      weigh([bend = options.huber_width * scale_](double deviation) {
        return deviation > bend ? bend / deviation : 1.0;
      });
      break;
    case LightingFitOptions::Loss::kSquares:
      weigh([](double) { return 1.0; });
      break;
  }
  mean_weight_ = 0.0;
  for (const double weight : weight_) mean_weight_ += weight;
  if (!weight_.empty()) mean_weight_ /= static_cast<double>(weight_.size());
}

// Samples of one plane follow each other, so that its sums stay in registers.
template <int kColumns>
void Reweighting::Accumulate(const FitProblem& problem) {
  using Row = Eigen::Matrix<double, kColumns, 1>;
  const auto cells = static_cast<std::size_t>(problem.plane_count) * 3;
  for (std::vector<double>* sums :
       {&plane_weight_, &plane_residual_, &plane_target_, &sky_mean_, &sky_sky_, &sky_target_}) {
    sums->assign(cells, 0.0);
  }
  plane_row_.assign(cells * kColumns, 0.0);
  sun_row_.assign(cells * kColumns, 0.0);
  sun_target_.assign(cells, 0.0);
  sky_per_sun_.assign(cells, 0.0);
  sky_row_.assign(cells * kColumns, 0.0);
  for (std::vector<double>* sums : {&trend_mean_, &trend_trend_, &trend_sky_, &trend_target_}) {
    sums->assign(cells, 0.0);
  }
  trend_row_.assign(cells * kColumns, 0.0);
  std::array<Eigen::Matrix<double, kColumns, kColumns>, 3> normal;
  normal.fill(Eigen::Matrix<double, kColumns, kColumns>::Zero());
  std::array<Row, 3> gradient;
  gradient.fill(Row::Zero());
  for (std::size_t first = 0; first < weight_.size();) {
    const std::int32_t plane = problem.plane[first];
    std::size_t last = first + 1;
    while (last < weight_.size() && problem.plane[last] == plane) ++last;
    for (std::size_t c = 0; c < 3; ++c) {
      double sum_weight = 0.0;
      double sum_residual = 0.0;
      double sum_target = 0.0;
      double sum_sky = 0.0;
      double sum_sky_sky = 0.0;
      double sum_sky_target = 0.0;
      Row sum_row = Row::Zero();
      Row sum_sky_row = Row::Zero();
      Row sum_target_row = Row::Zero();
      double sum_trend = 0.0;
      double sum_trend_trend = 0.0;
      double sum_trend_sky = 0.0;
      double sum_trend_target = 0.0;
      Row sum_trend_row = Row::Zero();
      Eigen::Matrix<double, kColumns, kColumns> sum_normal =
          Eigen::Matrix<double, kColumns, kColumns>::Zero();
      for (std::size_t i = first; i < last; ++i) {
        const std::size_t v = i * 3 + c;
        const double unit = inverse_unit_[v];
        const double weight = unit > 0.0 ? weight_[i] : 0.0;
        const double target = unit * problem.radiance[v];
        const double sky = weight * sky_share_[v];
        const Row row = unit * Eigen::Map<const Row>(problem.transport.data() + v * kColumns);
        const Row weighted = weight * row;
        sum_weight += weight;
        sum_residual += weight * residual_[v];
        sum_target += weight * target;
        sum_sky += sky;
        sum_sky_sky += sky * sky_share_[v];
        sum_sky_target += sky * target;
        sum_row += weighted;
        sum_sky_row += sky * row;
        sum_target_row += target * weighted;
        const double trend = weight * problem.trend[i];
        sum_trend += trend;
        sum_trend_trend += trend * problem.trend[i];
        sum_trend_sky += trend * sky_share_[v];
        sum_trend_target += trend * target;
        sum_trend_row += trend * row;
        sum_normal.noalias() += weighted * row.transpose();
      }
      normal[c] += sum_normal;
      gradient[c] += sum_target_row;
      if (!(sum_weight > 0.0)) continue;
      const std::size_t cell = static_cast<std::size_t>(plane) * 3 + c;
      const double inverse = 1.0 / sum_weight;
      plane_weight_[cell] = sum_weight;
      plane_residual_[cell] = sum_residual * inverse;
      plane_target_[cell] = sum_target * inverse;
      sky_mean_[cell] = sum_sky * inverse;
      sky_sky_[cell] = sum_sky_sky;
      sky_target_[cell] = sum_sky_target;
      Eigen::Map<Row>(plane_row_.data() + cell * kColumns) = inverse * sum_row;
      Eigen::Map<Row>(sky_row_.data() + cell * kColumns) = sum_sky_row;
      if (!problem.has_sun) continue;
      trend_mean_[cell] = sum_trend * inverse;
      trend_trend_[cell] = sum_trend_trend;
      trend_sky_[cell] = sum_trend_sky;
      trend_target_[cell] = sum_trend_target;
      Eigen::Map<Row>(trend_row_.data() + cell * kColumns) = sum_trend_row;
      Eigen::Map<Row>(sun_row_.data() + cell * kColumns) = sum_normal.col(0);
      sun_target_[cell] = sum_target_row[0];
      if (sum_normal(0, 0) > 0.0) sky_per_sun_[cell] = sum_sky_row[0] / sum_normal(0, 0);
    }
    first = last;
  }
  for (std::size_t c = 0; c < 3; ++c) {
    normal_[c] = normal[c];
    gradient_[c] = gradient[c];
  }
}

// Whitened rows are (row - phi mean row) sqrt(w / n), so their squares add up to
//   (sum w row row' - sum_planes (2 phi - phi^2) W mean mean') / n.
void Reweighting::WhitenMeans(const FitProblem& problem) {
  const int columns = problem.ColumnCount();
  const auto b = static_cast<std::size_t>(columns);
  taken_.resize(plane_weight_.size());
  for (std::size_t cell = 0; cell < taken_.size(); ++cell) {
    const std::size_t c = cell % 3;
    const auto ci = static_cast<Eigen::Index>(c);
    const double kept_squared =
        1.0 / (1.0 + Square(shared_error_) * plane_weight_[cell] / noise_(ci, ci));
    taken_[cell] = 1.0 - std::sqrt(kept_squared);
    const double part = (1.0 - kept_squared) * plane_weight_[cell];
    const Eigen::Map<const BasisVector> mean_row(plane_row_.data() + cell * b, columns);
    normal_[c].noalias() -= part * mean_row * mean_row.transpose();
    gradient_[c].noalias() -= part * plane_target_[cell] * mean_row;

    const double sky = part * sky_mean_[cell];
    sky_sky_[cell] -= sky * sky_mean_[cell];
    sky_target_[cell] -= sky * plane_target_[cell];
    Eigen::Map<BasisVector>(sky_row_.data() + cell * b, columns).noalias() -= sky * mean_row;
    const double sun = part * mean_row[0];
    sun_target_[cell] -= sun * plane_target_[cell];
    Eigen::Map<BasisVector>(sun_row_.data() + cell * b, columns).noalias() -= sun * mean_row;

    const double trend = part * trend_mean_[cell];
    trend_trend_[cell] -= trend * trend_mean_[cell];
    trend_sky_[cell] -= trend * sky_mean_[cell];
    trend_target_[cell] -= trend * plane_target_[cell];
    Eigen::Map<BasisVector>(trend_row_.data() + cell * b, columns).noalias() -= trend * mean_row;
  }
}

void Reweighting::WhitenSky(const FitProblem& problem) {
  const int columns = problem.ColumnCount();
  sky_taken_.assign(sky_sky_.size(), 0.0);
  for (std::size_t cell = 0; cell < sky_taken_.size(); ++cell) {
    const double sky_sky = sky_sky_[cell];
    if (!(sky_sky > 0.0)) continue;
    const std::size_t c = cell % 3;
    const auto ci = static_cast<Eigen::Index>(c);
    const double kept_squared = 1.0 / (1.0 + Square(sky_shape_error_) * sky_sky / noise_(ci, ci));
    sky_taken_[cell] = 1.0 - std::sqrt(kept_squared);
    Eigen::Map<BasisVector> row(sky_row_.data() + cell * static_cast<std::size_t>(columns),
                                columns);
    row /= sky_sky;
    sky_target_[cell] /= sky_sky;
    const double part = (1.0 - kept_squared) * sky_sky;
    normal_[c].noalias() -= part * row * row.transpose();
    gradient_[c].noalias() -= part * sky_target_[cell] * row;

    const double sun = part * row[0];
    sun_target_[cell] -= sun * sky_target_[cell];
    Eigen::Map<BasisVector>(sun_row_.data() + cell * static_cast<std::size_t>(columns), columns)
        .noalias() -= sun * row;

    trend_sky_[cell] /= sky_sky;
    const double trend = part * trend_sky_[cell];
    trend_trend_[cell] -= trend * trend_sky_[cell];
    trend_target_[cell] -= trend * sky_target_[cell];
    Eigen::Map<BasisVector>(trend_row_.data() + cell * static_cast<std::size_t>(columns), columns)
        .noalias() -= trend * row;
  }
}

void Reweighting::WhitenSun(const FitProblem& problem) {
  const int columns = problem.ColumnCount();
  sun_taken_.assign(sun_target_.size(), 0.0);
  trend_sun_.assign(sun_target_.size(), 0.0);
  if (!problem.has_sun) return;
  for (std::size_t cell = 0; cell < sun_taken_.size(); ++cell) {
    Eigen::Map<BasisVector> row(sun_row_.data() + cell * static_cast<std::size_t>(columns),
                                columns);
    const double sun_sun = row[0];
    if (!(sun_sun > 0.0)) continue;
    const std::size_t c = cell % 3;
    const auto ci = static_cast<Eigen::Index>(c);
    const double kept_squared =
        1.0 / (1.0 + Square(sky_shape_error_ * sky_per_sun_[cell]) * sun_sun / noise_(ci, ci));
    sun_taken_[cell] = 1.0 - std::sqrt(kept_squared);
    row /= sun_sun;
    sun_target_[cell] /= sun_sun;
    const double part = (1.0 - kept_squared) * sun_sun;
    normal_[c].noalias() -= part * row * row.transpose();
    gradient_[c].noalias() -= part * sun_target_[cell] * row;

    Eigen::Map<BasisVector> trend_row(trend_row_.data() + cell * static_cast<std::size_t>(columns),
                                      columns);
    const double along_sun = trend_row[0] / sun_sun;
    const double trend = part * along_sun;
    trend_trend_[cell] -= trend * along_sun;
    trend_target_[cell] -= trend * sun_target_[cell];
    trend_row.noalias() -= trend * row;
    trend_sun_[cell] = along_sun;
  }
}

void Reweighting::WhitenTrend(const FitProblem& problem) {
  const int columns = problem.ColumnCount();
  trend_taken_.assign(trend_trend_.size(), 0.0);
  for (std::size_t cell = 0; cell < trend_taken_.size(); ++cell) {
    const double trend_trend = trend_trend_[cell];
    if (!(trend_trend > 0.0)) continue;
    const std::size_t c = cell % 3;
    const auto ci = static_cast<Eigen::Index>(c);
    const double kept_squared = 1.0 / (1.0 + Square(trend_error_) * trend_trend / noise_(ci, ci));
    trend_taken_[cell] = 1.0 - std::sqrt(kept_squared);
    Eigen::Map<BasisVector> row(trend_row_.data() + cell * static_cast<std::size_t>(columns),
                                columns);
    row /= trend_trend;
    trend_target_[cell] /= trend_trend;
    const double part = (1.0 - kept_squared) * trend_trend;
    normal_[c].noalias() -= part * row * row.transpose();
    gradient_[c].noalias() -= part * trend_target_[cell] * row;
  }
}

void Reweighting::FinishNormal(const FitProblem& problem) {
  WhitenMeans(problem);
  WhitenSky(problem);
  WhitenSun(problem);
  WhitenTrend(problem);
  for (std::size_t c = 0; c < 3; ++c) {
    const double inverse = 1.0 / noise_(static_cast<Eigen::Index>(c), static_cast<Eigen::Index>(c));
    normal_[c] *= inverse;
    gradient_[c] *= inverse;
  }
}

void Reweighting::Whiten(const FitProblem& problem) {
  const int columns = problem.ColumnCount();
  const auto count = weight_.size();
  for (std::size_t c = 0; c < 3; ++c) {
    WhitenedChannel& channel = channels_[c];
    channel.rows.resize(count * static_cast<std::size_t>(columns));
    channel.target.resize(count);
    const auto ci = static_cast<Eigen::Index>(c);
    const double inverse_sigma = 1.0 / std::sqrt(noise_(ci, ci));
    double* out = channel.rows.data();
    for (std::size_t i = 0; i < count; ++i, out += columns) {
      const std::size_t v = i * 3 + c;
      const double unit = inverse_unit_[v];
      const double factor = unit > 0.0 ? std::sqrt(weight_[i]) * inverse_sigma : 0.0;
      const std::size_t cell = static_cast<std::size_t>(problem.plane[i]) * 3 + c;
      const double* row = problem.transport.data() + v * static_cast<std::size_t>(columns);
      const double* mean_row = plane_row_.data() + cell * static_cast<std::size_t>(columns);
      const double* sky_row = sky_row_.data() + cell * static_cast<std::size_t>(columns);
      const double* sun_row = sun_row_.data() + cell * static_cast<std::size_t>(columns);
      const double* trend_row = trend_row_.data() + cell * static_cast<std::size_t>(columns);
      const double by_sky = sky_taken_[cell] * (sky_share_[v] - taken_[cell] * sky_mean_[cell]);
      const double by_sun =
          sun_taken_[cell] * (unit * row[0] - taken_[cell] * mean_row[0] - by_sky * sky_row[0]);
      const double by_trend =
          trend_taken_[cell] * (problem.trend[i] - taken_[cell] * trend_mean_[cell] -
                                by_sky * trend_sky_[cell] - by_sun * trend_sun_[cell]);
      for (int j = 0; j < columns; ++j) {
        out[j] = factor * (unit * row[j] - taken_[cell] * mean_row[j] - by_sky * sky_row[j] -
                           by_sun * sun_row[j] - by_trend * trend_row[j]);
      }
      channel.target[i] =
          factor * (unit * problem.radiance[v] - taken_[cell] * plane_target_[cell] -
                    by_sky * sky_target_[cell] - by_sun * sun_target_[cell] -
                    by_trend * trend_target_[cell]);
    }
  }
}

BasisMatrix Reweighting::CrossNormal(int c, int d) const {
  const Eigen::Index columns = normal_[0].rows();
  BasisMatrix cross(columns, columns);
  const auto add = [&]<int kColumns>() {
    using Row = Eigen::Matrix<double, kColumns, 1>;
    Eigen::Matrix<double, kColumns, kColumns> sum =
        Eigen::Matrix<double, kColumns, kColumns>::Zero();
    const double* row_c = Channel(c).rows.data();
    const double* row_d = Channel(d).rows.data();
    for (std::size_t i = 0; i < weight_.size(); ++i, row_c += kColumns, row_d += kColumns) {
      sum.noalias() += Eigen::Map<const Row>(row_c) * Eigen::Map<const Row>(row_d).transpose();
    }
    Eigen::Map<Eigen::Matrix<double, kColumns, kColumns>>(cross.data()) = correlation_(c, d) * sum;
  };
  WithColumns(static_cast<int>(columns), add);
  return cross;
}

double Reweighting::InlierFraction() const {
  if (weight_.empty()) return 0.0;
  const auto inliers =
      std::count_if(weight_.begin(), weight_.end(), [](double w) { return w > 0.0; });
  return static_cast<double>(inliers) / static_cast<double>(weight_.size());
}

double Reweighting::RelativeResidual() const {
  double weights = 0.0;
  double squares = 0.0;
  for (std::size_t i = 0; i < weight_.size(); ++i) {
    weights += weight_[i];
    squares += weight_[i] * Square(deviation_[i]);
  }
  return weights > 0.0 ? std::sqrt(squares / weights) : 0.0;
}

}  // namespace pleinair::estimation_internal
