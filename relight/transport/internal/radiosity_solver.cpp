#include "relight/transport/internal/radiosity_solver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <type_traits>
#include <utility>
#include <vector>

#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/gtc/type_ptr.hpp>

namespace pleinair::internal {
namespace {

constexpr std::size_t kFacesPerTask = 256;

// A row holds `lights` lights of three channels each. A fourth channel, which is zero, makes the
// rows of few lights whole vectors of the processor.
struct Layout {
  std::size_t lights = 1;
  std::size_t stride = 3;
  std::size_t Floats() const { return lights * stride; }
};

constexpr std::size_t kMostFloats = 3 * kLightsPerBlock;
constexpr std::size_t kMostPadded = 8;  // Most lights that have a fourth channel.
static_assert(4 * kMostPadded <= kMostFloats);

// Per float of a block's row: largest change, and largest radiosity.
struct Maxima {
  std::array<float, kMostFloats> change{};
  std::array<float, kMostFloats> radiosity{};

  void Add(const Maxima& other) {
    for (std::size_t k = 0; k < kMostFloats; ++k) {
      change[k] = std::max(change[k], other.change[k]);
      radiosity[k] = std::max(radiosity[k], other.radiosity[k]);
    }
  }

  // The largest change of a light over its largest radiosity, all channels taken together.
  double RelativeChange(const Layout& layout, std::size_t light) const {
    const std::size_t k = layout.stride * light;
    const float largest_change = std::max({change[k], change[k + 1], change[k + 2]});
    const float largest = std::max({radiosity[k], radiosity[k + 1], radiosity[k + 2]});
    return largest > 0.0f ? static_cast<double>(largest_change) / largest : 0.0;
  }
};

// One block's arrays and the sweep over them. kFloats is the row's length where it is known to the
// compiler, else 0.
template <std::size_t kFloats>
class Sweep {
 public:
  Sweep(const FormFactorRows& rows,
        std::span<const glm::vec3> albedo,
        std::span<const float> direct,
        const Layout& layout)
      : rows_(rows),
        albedo_(albedo),
        direct_(direct),
        layout_(layout),
        tasks_((rows.Count() + kFacesPerTask - 1) / kFacesPerTask),
        order_(rows.Count()),
        maxima_(tasks_) {
    std::iota(order_.begin(), order_.end(), 0u);
    tbb::parallel_for(std::size_t{0}, tasks_, [&](std::size_t task) {
      const std::size_t first = task * kFacesPerTask;
      const auto of_task =
          std::span(order_).subspan(first, std::min(kFacesPerTask, order_.size() - first));
      std::stable_sort(of_task.begin(), of_task.end(), [&](std::uint32_t a, std::uint32_t b) {
        return LengthOf(a) < LengthOf(b);
      });
    });
  }

  // next = albedo (direct + F current); a null `current` is all dark. Where `omega`, by float of a
  // row, is not 1, next = previous + omega (albedo (direct + F current) - previous), previous being
  // what `next` held. The change is what the first of these would have changed.
  Maxima Run(const float* current, std::span<const float> omega, float* next) {
    omega_ = omega;
    tbb::parallel_for(std::size_t{0}, tasks_, [&](std::size_t task) {
      maxima_[task] = Maxima{};
      const std::size_t end = std::min(rows_.Count(), (task + 1) * kFacesPerTask);
      for (std::size_t i = task * kFacesPerTask; i < end; i += kRowsTogether) {
        const std::size_t count = std::min(kRowsTogether, end - i);
        DoRows(std::span(order_).subspan(i, count), current, next, maxima_[task]);
      }
    });
    Maxima all;
    for (const Maxima& task : maxima_) all.Add(task);
    return all;
  }

 private:
  // Short rows are added up beside each other: an addition need not wait for the one before it.
  static constexpr std::size_t kRowsTogether = kFloats == 0 || kFloats > 16 ? 1 : 4;
  using RowOfFloats = std::array<float, kFloats == 0 ? kMostFloats : kFloats>;

  std::size_t Floats() const { return kFloats == 0 ? layout_.Floats() : kFloats; }
  std::uint64_t LengthOf(std::size_t row) const { return rows_.begin[row + 1] - rows_.begin[row]; }

  // The sum of F current over each row's own entries in their order, several rows at a time.
  void DoRows(std::span<const std::uint32_t> rows,
              const float* current,
              float* next,
              Maxima& maxima) const {
    const std::size_t floats = Floats();
    std::array<RowOfFloats, kRowsTogether> sums;
    for (RowOfFloats& sum : sums) std::fill_n(sum.begin(), floats, 0.0f);
    if (current != nullptr) {
      const auto add = [&](std::uint64_t k, RowOfFloats& sum) {
        const float share = rows_.share[k];
        const float* const source = current + static_cast<std::size_t>(rows_.face[k]) * floats;
        for (std::size_t j = 0; j < floats; ++j) sum[j] += share * source[j];
      };
      const std::uint64_t together = rows.size() == kRowsTogether ? LengthOf(rows.front()) : 0;
      for (std::uint64_t k = 0; k < together; ++k) {
        for (std::size_t r = 0; r < kRowsTogether; ++r) add(rows_.begin[rows[r]] + k, sums[r]);
      }
      for (std::size_t r = 0; r < rows.size(); ++r) {
        for (std::uint64_t k = together; k < LengthOf(rows[r]); ++k) {
          add(rows_.begin[rows[r]] + k, sums[r]);
        }
      }
    }
    for (std::size_t r = 0; r < rows.size(); ++r) Finish(rows[r], sums[r], current, next, maxima);
  }

  void Finish(
      std::size_t i, RowOfFloats& sum, const float* current, float* next, Maxima& maxima) const {
    const std::size_t floats = Floats();
    const float* const direct = direct_.data() + i * floats;
    float* const out = next + i * floats;
    const float* const before = current == nullptr ? nullptr : current + i * floats;
    const glm::vec3 albedo = albedo_[i];
    for (std::size_t j = 0; j < floats; j += layout_.stride) {
      for (std::size_t channel = 0; channel < 3; ++channel) {
        const std::size_t k = j + channel;
        sum[k] = albedo[static_cast<glm::length_t>(channel)] * (direct[k] + sum[k]);
      }
    }
    for (std::size_t j = 0; j < floats; ++j) {
      const float change = before == nullptr ? sum[j] : std::abs(sum[j] - before[j]);
      maxima.change[j] = std::max(maxima.change[j], change);
      maxima.radiosity[j] = std::max(maxima.radiosity[j], sum[j]);
      out[j] = omega_[j] == 1.0f ? sum[j] : out[j] + omega_[j] * (sum[j] - out[j]);
    }
  }

  const FormFactorRows& rows_;
  std::span<const glm::vec3> albedo_;
  std::span<const float> direct_;
  Layout layout_;
  std::size_t tasks_;
  std::vector<std::uint32_t> order_;  // The rows, within a task the shortest ones first.
  std::vector<Maxima> maxima_;
  std::span<const float> omega_;
};

// The iteration of one light. It starts with single reflections, and goes on with Chebyshev's
// polynomials once these show how fast they fade. Source: Golub and Varga, "Chebyshev
// semi-iterative methods, successive overrelaxation iterative methods, and second order Richardson
// iterative methods", 1961. Form factors times albedo have real eigenvalues, but for the rays'
// scatter; of the largest one what has been seen is a lower bound. Too low a bound slows
// convergence and does not change the result; it is detected by that, and raised (Hageman and
// Young, "Applied iterative methods", 1981, chapter 5).
class Approach {
 public:
  bool IsDone() const { return is_done_; }
  void End() { is_done_ = true; }
  // Weight of the next sweep.
  double Omega() const { return omega_; }
  // After a sweep, in which one reflection would have changed the light by so much of itself:
  // whether less than `tolerance` of it is missing, or as little as float's rounding allows.
  bool IsSolved(double change, double tolerance) {
    since_least_ = change < least_change_ ? 0 : since_least_ + 1;
    least_change_ = std::min(change, least_change_);
    return Missing(change) < tolerance || change < kRounding || since_least_ == kPatience;
  }

 private:
  double Missing(double change) {
    const double previous = std::exchange(previous_change_, change);
    const double fading = previous > 0.0 ? change / previous : 0.5;
    ++sweeps_;
    double eigenvalue = std::min(fading, kMost);
    if (is_accelerated_ && change < 10.0 * kRounding) {
      eigenvalue = bound_;
    } else if (is_accelerated_) {
      const double root = 1.0 + std::sqrt(1.0 - bound_ * bound_);
      const double z = fading * root;
      eigenvalue = z > bound_ ? std::min(0.5 * (z + bound_ * bound_ / z), kMost) : bound_;
    }
    const bool is_higher = 1.0 - eigenvalue < kTooLow * (1.0 - bound_);
    if (sweeps_ >= kSweepsToSee && (!is_accelerated_ || is_higher)) {
      is_accelerated_ = true;
      bound_ = eigenvalue;
      omega_ = 1.0 / (1.0 - 0.5 * bound_ * bound_);
      sweeps_ = 0;
    } else if (is_accelerated_) {
      omega_ = 1.0 / (1.0 - 0.25 * bound_ * bound_ * omega_);
    }
    // What single reflections would still add.
    return change * eigenvalue / (1.0 - eigenvalue);
  }

  static constexpr int kSweepsToSee = 4;
  static constexpr double kTooLow = 0.8;
  static constexpr double kMost = 0.999;
  static constexpr double kRounding = 1e-6;  // Relative error of a face's sum.
  static constexpr int kPatience = 50;       // Sweeps without any progress.

  double least_change_ = std::numeric_limits<double>::infinity();
  int since_least_ = 0;
  int sweeps_ = 0;  // Since the bound changed.
  double previous_change_ = 0.0;
  double bound_ = 0.0;
  double omega_ = 1.0;
  bool is_accelerated_ = false;
  bool is_done_ = false;
};

// A light stops when it would by itself: lights that are solved together do not affect each other.
// take(light, values) is called for each once, with all values of the block.
template <std::size_t kFloats, class Take>
BlockSolution Iterate(Sweep<kFloats> sweep,
                      std::size_t faces,
                      const Layout& layout,
                      const SolveEnd& end,
                      const Take& take) {
  // Far above what is needed: with albedo 0.98 all around some 100 sweeps, 700 unaccelerated.
  constexpr int kMaxIterations = 5000;
  const int last = end.reflections < 0 ? kMaxIterations : end.reflections;
  std::vector<float> current(faces * layout.Floats(), 0.0f);
  std::vector<float> next(current);
  std::vector<float> omega(layout.Floats(), 1.0f);
  sweep.Run(nullptr, omega, current.data());
  BlockSolution solution{.iterations = 1, .residual = 0.0};
  std::vector<Approach> approach(layout.lights);
  std::size_t done = 0;
  const auto finish = [&](std::size_t light) {
    approach[light].End();
    ++done;
    take(light, current);
  };
  while (solution.iterations < last && done < layout.lights) {
    const Maxima maxima = sweep.Run(current.data(), omega, next.data());
    current.swap(next);
    ++solution.iterations;
    if (end.reflections >= 0) continue;
    for (std::size_t light = 0; light < layout.lights; ++light) {
      if (approach[light].IsDone()) continue;
      const double change = maxima.RelativeChange(layout, light);
      const bool is_solved = approach[light].IsSolved(change, end.tolerance);
      std::fill_n(omega.begin() + static_cast<std::ptrdiff_t>(light * layout.stride),
                  layout.stride,
                  static_cast<float>(approach[light].Omega()));
      if (is_solved || solution.iterations == last) {
        solution.residual = std::max(solution.residual, change);
        finish(light);
      }
    }
  }
  for (std::size_t light = 0; light < layout.lights; ++light) {
    if (!approach[light].IsDone()) finish(light);
  }
  return solution;
}

}  // namespace

BlockSolution SolveBlock(const FormFactorRows& rows,
                         std::span<const glm::vec3> albedo,
                         const LightBlock& block,
                         const SolveEnd& end,
                         std::span<glm::vec3> radiosity) {
  const std::size_t faces = rows.Count();
  if (faces == 0 || block.solved == 0) return {};
  const Layout layout{block.solved, block.solved <= kMostPadded ? std::size_t{4} : std::size_t{3}};
  std::vector<float> own_direct(faces * layout.Floats(), 0.0f);
  for (std::size_t face = 0; face < faces; ++face) {
    for (std::size_t light = 0; light < block.solved; ++light) {
      std::copy_n(glm::value_ptr(block.direct[face * block.count + block.first + light]),
                  3,
                  own_direct.data() + face * layout.Floats() + light * layout.stride);
    }
  }
  const auto take = [&](std::size_t light, std::span<const float> solved) {
    for (std::size_t face = 0; face < faces; ++face) {
      const float* const from = solved.data() + face * layout.Floats() + light * layout.stride;
      // Acceleration may overshoot, and leave values below 0.
      radiosity[face * block.count + block.first + light] =
          glm::max(glm::vec3(from[0], from[1], from[2]), 0.0f);
    }
  };
  const auto run = [&]<std::size_t kFloats>(std::integral_constant<std::size_t, kFloats>) {
    return Iterate(Sweep<kFloats>(rows, albedo, own_direct, layout), faces, layout, end, take);
  };
  switch (layout.Floats()) {
    case 4:
      return run(std::integral_constant<std::size_t, 4>{});
    case 8:
      return run(std::integral_constant<std::size_t, 8>{});
    case 16:
      return run(std::integral_constant<std::size_t, 16>{});
    case kMostFloats:
      return run(std::integral_constant<std::size_t, kMostFloats>{});
    default:
      return run(std::integral_constant<std::size_t, 0>{});
  }
}

}  // namespace pleinair::internal
