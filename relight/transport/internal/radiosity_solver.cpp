#include "relight/transport/internal/radiosity_solver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <tbb/parallel_for.h>
#include <glm/gtc/type_ptr.hpp>

namespace pleinair::internal {
namespace {

constexpr std::size_t kFacesPerTask = 256;
constexpr std::size_t kMostFloats = 3 * kLightsPerBlock;

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
};

// The largest relative change of any light, its three channels taken together.
double LargestRelativeChange(const Maxima& maxima, std::size_t floats) {
  double largest = 0.0;
  for (std::size_t k = 0; k < floats; k += 3) {
    const float change = std::max({maxima.change[k], maxima.change[k + 1], maxima.change[k + 2]});
    const float radiosity =
        std::max({maxima.radiosity[k], maxima.radiosity[k + 1], maxima.radiosity[k + 2]});
    if (radiosity > 0.0f) largest = std::max(largest, static_cast<double>(change) / radiosity);
  }
  return largest;
}

// One block's arrays and the sweep over them. kFloats is the row's length where it is known to the
// compiler, else 0.
template <std::size_t kFloats>
class Sweep {
 public:
  Sweep(const FormFactorRows& rows,
        std::span<const glm::vec3> albedo,
        const float* direct,
        std::size_t direct_stride,
        std::size_t floats)
      : rows_(rows),
        albedo_(albedo),
        direct_(direct),
        direct_stride_(direct_stride),
        floats_(floats),
        tasks_((rows.Count() + kFacesPerTask - 1) / kFacesPerTask),
        maxima_(tasks_) {}

  std::size_t Floats() const { return kFloats == 0 ? floats_ : kFloats; }

  // next = albedo (direct + F current); a null `current` is all dark.
  Maxima Run(const float* current, float* next) {
    tbb::parallel_for(std::size_t{0}, tasks_, [&](std::size_t task) {
      maxima_[task] = Maxima{};
      const std::size_t end = std::min(rows_.Count(), (task + 1) * kFacesPerTask);
      for (std::size_t i = task * kFacesPerTask; i < end; ++i) Row(i, current, next, maxima_[task]);
    });
    Maxima all;
    for (const Maxima& task : maxima_) all.Add(task);
    return all;
  }

 private:
  void Row(std::size_t i, const float* current, float* next, Maxima& maxima) const {
    const std::size_t floats = Floats();
    std::array<float, kFloats == 0 ? kMostFloats : kFloats> sum;
    const float* const direct = direct_ + i * direct_stride_;
    std::fill_n(sum.begin(), floats, 0.0f);
    if (current != nullptr) {
      for (std::uint64_t k = rows_.begin[i]; k < rows_.begin[i + 1]; ++k) {
        const float share = rows_.share[k];
        const float* const source = current + static_cast<std::size_t>(rows_.face[k]) * floats;
        for (std::size_t j = 0; j < floats; ++j) sum[j] += share * source[j];
      }
    }
    float* const out = next + i * floats;
    const float* const before = current == nullptr ? nullptr : current + i * floats;
    const glm::vec3 albedo = albedo_[i];
    for (std::size_t j = 0; j < floats; j += 3) {
      for (std::size_t channel = 0; channel < 3; ++channel) {
        const std::size_t k = j + channel;
        out[k] = albedo[static_cast<glm::length_t>(channel)] * (direct[k] + sum[k]);
      }
    }
    for (std::size_t j = 0; j < floats; ++j) {
      const float change = before == nullptr ? out[j] : std::abs(out[j] - before[j]);
      maxima.change[j] = std::max(maxima.change[j], change);
      maxima.radiosity[j] = std::max(maxima.radiosity[j], out[j]);
    }
  }

  const FormFactorRows& rows_;
  std::span<const glm::vec3> albedo_;
  const float* direct_;
  std::size_t direct_stride_;
  std::size_t floats_;
  std::size_t tasks_;
  std::vector<Maxima> maxima_;
};

template <std::size_t kFloats>
BlockSolution Iterate(Sweep<kFloats>& sweep,
                      std::size_t faces,
                      int reflections,
                      double tolerance,
                      std::vector<float>& current) {
  // With albedo 0.98 all around the ratio of successive changes is 0.98, and 1e-6 takes some 700
  // iterations.
  constexpr int kMaxIterations = 5000;
  const int last = reflections < 0 ? kMaxIterations : reflections;
  std::vector<float> next(faces * sweep.Floats());
  current.resize(faces * sweep.Floats());
  sweep.Run(nullptr, current.data());
  BlockSolution solution{.iterations = 1, .residual = 0.0};
  double previous_change = 0.0;
  while (solution.iterations < last) {
    const Maxima maxima = sweep.Run(current.data(), next.data());
    current.swap(next);
    ++solution.iterations;
    const double change = LargestRelativeChange(maxima, sweep.Floats());
    if (reflections < 0) {
      solution.residual = change;
      // What later iterations would add is change * q / (1 - q), q the ratio of successive changes.
      const double q = previous_change > 0.0 ? std::min(change / previous_change, 0.999) : 0.5;
      // Below float's step nothing changes any more.
      if (change * q / (1.0 - q) < tolerance || change < 1e-7) break;
    }
    previous_change = change;
  }
  return solution;
}

}  // namespace

BlockSolution SolveBlock(const FormFactorRows& rows,
                         std::span<const glm::vec3> albedo,
                         std::span<const glm::vec3> direct,
                         std::size_t lights,
                         std::size_t first,
                         std::size_t count,
                         int reflections,
                         double tolerance,
                         std::span<glm::vec3> radiosity) {
  const std::size_t faces = rows.Count();
  if (faces == 0 || count == 0) return {};
  const float* const direct_of_first = glm::value_ptr(direct[first]);
  std::vector<float> solved;
  const auto run = [&](auto sweep) {
    return Iterate(sweep, faces, reflections, tolerance, solved);
  };
  BlockSolution solution;
  if (count == 1) {
    solution = run(Sweep<3>(rows, albedo, direct_of_first, 3 * lights, 3));
  } else if (count == kLightsPerBlock) {
    solution = run(Sweep<kMostFloats>(rows, albedo, direct_of_first, 3 * lights, kMostFloats));
  } else {
    solution = run(Sweep<0>(rows, albedo, direct_of_first, 3 * lights, 3 * count));
  }
  for (std::size_t face = 0; face < faces; ++face) {
    std::copy_n(solved.data() + face * 3 * count,
                3 * count,
                glm::value_ptr(radiosity[face * lights + first]));
  }
  return solution;
}

}  // namespace pleinair::internal
