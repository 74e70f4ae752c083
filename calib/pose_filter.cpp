#include "calib/pose_filter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "calib/internal/check_number.h"
#include "scene/upper_median.h"

namespace pleinair {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr std::size_t kMostPoses = 256;  // For fast trackers: bounds the cost.
// Below what any picture shows, and above rounding errors of poses 1e6 m from the origin.
constexpr double kLeastNoisePx = 0.002;

// A change of pose as a vector whose length is the shift in the picture. The shift is in rms pixels
// over points at the middle of the view and halfway to its corners, at two distances.
class PixelMetric {
 public:
  PixelMetric(const CameraIntrinsics& camera, double distance_m) {
    const double x = 0.25 * camera.width_px / camera.fx_px;
    const double y = 0.25 * camera.height_px / camera.fy_px;
    const std::array<std::array<double, 2>, 5> directions = {
        {{0.0, 0.0}, {-x, -y}, {x, -y}, {-x, y}, {x, y}}};
    Matrix6 sum = Matrix6::Zero();
    int points = 0;
    for (const auto& [a, b] : directions) {
      for (const double depth_m : {0.5 * distance_m, 2.0 * distance_m}) {
        // A point p = depth (a, b, 1) comes to exp(turned) (p - moved).
        Eigen::Matrix<double, 2, 6> pixel;
        pixel.row(0) << -1.0 / depth_m, 0.0, a / depth_m, -a * b, 1.0 + a * a, -b;
        pixel.row(1) << 0.0, -1.0 / depth_m, b / depth_m, -1.0 - b * b, a * b, a;
        pixel.row(0) *= camera.fx_px;
        pixel.row(1) *= camera.fy_px;
        sum += pixel.transpose() * pixel;
        ++points;
      }
    }
    root_ = (sum / points).llt().matrixU();
  }

  Vector6 Of(const PoseChange& change) const {
    Vector6 vector;
    vector << change.moved_m.x, change.moved_m.y, change.moved_m.z, change.turned_rad.x,
        change.turned_rad.y, change.turned_rad.z;
    return root_ * vector;
  }
  PoseChange From(const Vector6& pixels) const {
    const Vector6 vector = root_.triangularView<Eigen::Upper>().solve(pixels);
    return {{vector[0], vector[1], vector[2]}, {vector[3], vector[4], vector[5]}};
  }

 private:
  Matrix6 root_;  // Upper triangular; its square is the mean of the points' squared motions.
};

struct PoseNoise {
  double variance_px2 = 0.0;  // Summed over the six.
  double degrees = 6.0;       // Degrees of freedom: 1 where all of the variance is along one.
};

// Distance of each pose from the line between its neighbours, in units of a pose's own noise.
PoseNoise NoiseOf(const std::vector<Vector6>& places, const std::deque<TimedPose>& poses) {
  std::vector<Vector6> off;
  std::vector<double> squares;
  for (std::size_t i = 1; i + 1 < places.size(); ++i) {
    const double share = SecondsFromTo(poses[i - 1].time, poses[i].time) /
                         SecondsFromTo(poses[i - 1].time, poses[i + 1].time);
    const double gain = std::sqrt(1.0 + share * share + (1.0 - share) * (1.0 - share));
    off.push_back((places[i] - (1.0 - share) * places[i - 1] - share * places[i + 1]) / gain);
    squares.push_back(off.back().squaredNorm());
  }
  // Three times the median deviation: beyond it are jumps, and of pure noise less than 5 %.
  constexpr double kMostOfMedian = 9.0;
  const double most = kMostOfMedian * UpperMedian(squares);
  Matrix6 covariance = Matrix6::Zero();
  int used = 0;
  for (std::size_t i = 0; i < off.size(); ++i) {
    if (squares[i] > most) continue;
    covariance += off[i] * off[i].transpose();
    ++used;
  }
  covariance /= std::max(used, 1);
  covariance += Matrix6::Identity() * (kLeastNoisePx * kLeastNoisePx / 6.0);
  const double trace = covariance.trace();
  return {trace, trace * trace / covariance.squaredNorm()};
}

// The value, over its expectation, that a squared mean of noise exceeds once in 10^4 times: Wilson
// and Hilferty's chi-square (PNAS 17(12), 1931).
double LargestOfNoise(double degrees) {
  constexpr double kNormalQuantile = 3.719;  // Normal quantile of 1 - 1e-4.
  const double variance = 2.0 / (9.0 * degrees);
  const double root = 1.0 - variance + kNormalQuantile * std::sqrt(variance);
  return root * root * root;
}

// Sums of the last 0, 1, 2 ... places.
std::vector<Vector6> SumsFromTheEnd(const std::vector<Vector6>& places) {
  std::vector<Vector6> sums(places.size() + 1, Vector6::Zero());
  for (std::size_t n = 1; n <= places.size(); ++n) {
    sums[n] = sums[n - 1] + places[places.size() - n];
  }
  return sums;
}

bool IsAtRest(const std::vector<Vector6>& sums, std::size_t run, double largest_px2) {
  const auto changes_after = [&](std::size_t last) {
    const auto later = static_cast<double>(last);
    const auto earlier = static_cast<double>(run - last);
    const Vector6 change = sums[last] / later - (sums[run] - sums[last]) / earlier;
    return change.squaredNorm() > largest_px2 * (1.0 / later + 1.0 / earlier);
  };
  for (std::size_t part = 1; 2 * part <= run; part *= 2) {
    if (changes_after(part) || changes_after(run - part)) return false;
  }
  return true;
}

}  // namespace

void PoseFilterOptions::Validate() const {
  RequireOption(distance_m > 0.0 && std::isfinite(distance_m), "distance_m", distance_m, "above 0");
  RequireOption(window_s > 0.0 && std::isfinite(window_s), "window_s", window_s, "above 0");
  RequireOption(least_poses >= 4, "least_poses", least_poses, "4 or more");
  RequireOption(most_noise_px >= 0.0, "most_noise_px", most_noise_px, "0 or more");
}

PoseFilter::PoseFilter(const PoseFilterOptions& options) : options_(options) { options.Validate(); }

glm::dmat4 PoseFilter::Update(const CameraIntrinsics& camera,
                              const TimedPose& pose,
                              PoseFilterState& state) const {
  if (const std::string fault = FaultOfPose(pose.camera_from_world); !fault.empty()) {
    throw std::invalid_argument("camera pose: expected " + fault);
  }
  std::deque<TimedPose>& recent = state.recent;
  if (!recent.empty() && pose.time > recent.back().time &&
      pose.camera_from_world == recent.back().camera_from_world) {
    return state.last_result;
  }
  if (!recent.empty() && pose.time <= recent.back().time) recent.clear();
  recent.push_back(pose);
  while (recent.size() > kMostPoses ||
         SecondsFromTo(recent.front().time, pose.time) > options_.window_s) {
    recent.pop_front();
  }
  state.last_result = pose.camera_from_world;
  state.averaged = 1;
  state.noise_px = 0.0;
  const auto least = static_cast<std::size_t>(options_.least_poses);
  if (recent.size() < least) return state.last_result;

  const PixelMetric metric(camera, options_.distance_m);
  std::vector<Vector6> places;
  places.reserve(recent.size());
  for (const TimedPose& one : recent) {
    places.push_back(metric.Of(ChangeBetween(pose.camera_from_world, one.camera_from_world)));
  }
  const PoseNoise noise = NoiseOf(places, recent);
  state.noise_px = std::sqrt(noise.variance_px2);
  const double largest_px2 =
      std::min(noise.variance_px2, options_.most_noise_px * options_.most_noise_px) *
      LargestOfNoise(noise.degrees);
  const std::vector<Vector6> sums = SumsFromTheEnd(places);
  for (std::size_t run = places.size(); run >= least; --run) {
    if (!IsAtRest(sums, run, largest_px2)) continue;
    state.last_result =
        Changed(pose.camera_from_world, metric.From(sums[run] / static_cast<double>(run)));
    state.averaged = static_cast<int>(run);
    break;
  }
  return state.last_result;
}

}  // namespace pleinair
