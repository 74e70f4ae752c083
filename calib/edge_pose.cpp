#include "calib/edge_pose.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include <ceres/tiny_solver.h>
#include <ceres/tiny_solver_autodiff_function.h>
#include <Eigen/Dense>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <opencv2/imgproc.hpp>

#include "calib/internal/reprojection.h"
#include "calib/internal/residual_text.h"
#include "scene/upper_median.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

constexpr double kSampleStepPx = 8.0;
// While poses are tried, and once one is chosen.
constexpr std::size_t kFewSamples = 160;
constexpr std::size_t kMostSamples = 800;
constexpr double kNearestM = 0.05;
constexpr double kProfileStepPx = 0.75;
// A step of light counts from here on, in codes a pixel, and as a share of the profile's steepest.
constexpr double kLeastSlope = 1.5;
constexpr double kLeastSlopeShare = 0.25;
constexpr double kAlongShare = 0.7;  // Slope along the edge over that across it.
constexpr double kNearPx = 2.0;      // A picture's edge so near is the mesh's.
// How near edges are where a pose is right; those of a wrong one are drawn near, and miss by more.
constexpr double kSharpPx = 0.7;
constexpr std::size_t kFewestSamples = 40;
constexpr double kLeastShareOverChance = 0.2;
// A pose on whose edges the picture has this share of what the best one's have is as good.
constexpr double kRivalShare = 0.9;

UndeterminedPose OpenPose(const std::string& why, std::vector<PoseCandidate> candidates = {}) {
  return {"the camera's pose cannot be determined from edges: " + why, std::move(candidates)};
}

// Steepness of a smoothed picture's light, at each place and for any direction: the structure
// tensor, summed over the channels.
class Slopes {
 public:
  Slopes(const Rgb8Image& picture, double sigma_px)
      : tensor_(picture.height, picture.width, CV_32FC3, cv::Scalar(0.0)) {
    const cv::Mat codes(
        picture.height, picture.width, CV_8UC3, const_cast<glm::u8vec3*>(picture.pixels.data()));
    cv::Mat smooth;
    codes.convertTo(smooth, CV_32FC3);
    cv::GaussianBlur(smooth, smooth, {}, sigma_px);
    for (int y = 1; y + 1 < smooth.rows; ++y) {
      for (int x = 1; x + 1 < smooth.cols; ++x) {
        const cv::Vec3f dx =
            0.5f * (smooth.at<cv::Vec3f>(y, x + 1) - smooth.at<cv::Vec3f>(y, x - 1));
        const cv::Vec3f dy =
            0.5f * (smooth.at<cv::Vec3f>(y + 1, x) - smooth.at<cv::Vec3f>(y - 1, x));
        tensor_.at<cv::Vec3f>(y, x) = {dx.dot(dx), dx.dot(dy), dy.dot(dy)};
      }
    }
  }

  bool Holds(const glm::dvec2& at, double margin_px) const {
    return at.x >= margin_px && at.y >= margin_px && at.x <= tensor_.cols - 1 - margin_px &&
           at.y <= tensor_.rows - 1 - margin_px;
  }

  // Codes a pixel along a unit direction, the root of the sum over channels squared.
  double Slope(const glm::dvec2& at, const glm::dvec2& direction) const {
    const int x = std::clamp(static_cast<int>(at.x), 0, tensor_.cols - 2);
    const int y = std::clamp(static_cast<int>(at.y), 0, tensor_.rows - 2);
    const float fx = static_cast<float>(std::clamp(at.x - x, 0.0, 1.0));
    const float fy = static_cast<float>(std::clamp(at.y - y, 0.0, 1.0));
    const auto* upper = tensor_.ptr<cv::Vec3f>(y) + x;
    const auto* lower = tensor_.ptr<cv::Vec3f>(y + 1) + x;
    const cv::Vec3f t = (1.0f - fy) * ((1.0f - fx) * upper[0] + fx * upper[1]) +
                        fy * ((1.0f - fx) * lower[0] + fx * lower[1]);
    const double squared = t[0] * direction.x * direction.x +
                           2.0 * t[1] * direction.x * direction.y +
                           t[2] * direction.y * direction.y;
    return std::sqrt(std::max(squared, 0.0));
  }

 private:
  cv::Mat tensor_;  // (dx dx, dx dy, dy dy).
};

// A place on an edge that the camera sees, and where the picture has edges along its normal.
struct Sample {
  std::size_t edge = 0;
  glm::dvec3 point_m{0.0};
  glm::dvec2 pixel{0.0};
  glm::dvec2 normal{0.0};
  std::vector<double> steps_px;  // Offsets along the normal.

  double NearestPx() const {
    double nearest = std::numeric_limits<double>::infinity();
    for (const double step : steps_px) {
      if (std::abs(step) < std::abs(nearest)) nearest = step;
    }
    return nearest;
  }
};

// Offsets of the picture's steps of light along a sample's normal.
std::vector<double> StepsAlong(const Slopes& slopes, const Sample& sample, double reach_px) {
  const int count = static_cast<int>(std::ceil(reach_px / kProfileStepPx));
  std::vector<double> profile;
  double steepest = 0.0;
  for (int i = -count - 1; i <= count + 1; ++i) {
    profile.push_back(
        slopes.Slope(sample.pixel + i * kProfileStepPx * sample.normal, sample.normal));
    steepest = std::max(steepest, profile.back());
  }
  const double least = std::max(kLeastSlope, kLeastSlopeShare * steepest);
  const glm::dvec2 along(-sample.normal.y, sample.normal.x);
  std::vector<double> steps;
  for (std::size_t i = 1; i + 1 < profile.size(); ++i) {
    const double here = profile[i];
    if (!(here >= least && here > profile[i - 1] && here >= profile[i + 1])) continue;
    const double bend = profile[i - 1] - 2.0 * here + profile[i + 1];
    const double part = bend < 0.0 ? 0.5 * (profile[i - 1] - profile[i + 1]) / bend : 0.0;
    const double offset = (static_cast<double>(i) - count - 1 + part) * kProfileStepPx;
    if (slopes.Slope(sample.pixel + offset * sample.normal, along) > kAlongShare * here) continue;
    steps.push_back(offset);
  }
  return steps;
}

// The mesh as one camera sees it.
class EdgeView {
 public:
  EdgeView(const Lens& lens, std::span<const MeshEdge> edges, const RayCaster& rays)
      : lens_(lens), edges_(edges), rays_(rays) {}

  // Places on the edges in view, kSampleStepPx apart or so that there are no more than `most`.
  std::vector<Sample> SamplesOf(const glm::dmat4& pose,
                                const Slopes& slopes,
                                std::size_t most = kMostSamples) const {
    const glm::dvec3 eye(glm::inverse(pose)[3]);
    std::vector<Sample> samples;
    for (std::size_t i = 0; i < edges_.size(); ++i) AddSamples(i, pose, eye, slopes, samples);
    if (samples.size() > most) {
      std::vector<Sample> fewer;
      for (std::size_t i = 0; i < most; ++i) fewer.push_back(samples[i * samples.size() / most]);
      samples = std::move(fewer);
    }
    std::vector<Sample> seen;
    for (Sample& sample : samples) {
      const glm::dvec3 to = sample.point_m - eye;
      const double distance = glm::length(to);
      // The edge's own faces end there: what stops the ray a hundredth before it stands before it.
      if (!rays_.Occluded(
              glm::vec3(eye), glm::vec3(to / distance), static_cast<float>(0.99 * distance))) {
        seen.push_back(std::move(sample));
      }
    }
    return seen;
  }

  std::optional<glm::dvec2> Project(const glm::dmat4& pose, const glm::dvec3& point) const {
    const glm::dvec3 at(pose * glm::dvec4(point, 1.0));
    if (!(at.z > kNearestM)) return std::nullopt;
    return lens_.ProjectToPixel(at);
  }
  const CameraIntrinsics& Intrinsics() const { return lens_.Intrinsics(); }

 private:
  void AddSamples(std::size_t index,
                  const glm::dmat4& pose,
                  const glm::dvec3& eye,
                  const Slopes& slopes,
                  std::vector<Sample>& samples) const {
    const MeshEdge& edge = edges_[index];
    if (!edge.is_sharp && !edge.IsOutlineFrom(eye)) return;
    constexpr int kParts = 48;
    constexpr double kMarginPx = 4.0;
    std::optional<glm::dvec2> before;
    double since_px = 0.5 * kSampleStepPx;
    for (int part = 0; part <= kParts; ++part) {
      const double share = static_cast<double>(part) / kParts;
      const auto here = Project(pose, glm::mix(edge.from_m, edge.to_m, share));
      // A part that is longer begins beside the camera: little of it is in view.
      constexpr double kLongestPx = 4000.0;
      if (here && before && glm::distance(*before, *here) < kLongestPx) {
        const double length = glm::distance(*before, *here);
        // Places at every kSampleStepPx along the way.
        double at = kSampleStepPx - since_px;
        for (; at < length; at += kSampleStepPx) {
          const double inside = at / length;
          Sample sample;
          sample.edge = index;
          sample.point_m =
              glm::mix(edge.from_m, edge.to_m, (part - 1 + inside) / static_cast<double>(kParts));
          sample.pixel = glm::mix(*before, *here, inside);
          sample.normal = glm::dvec2(before->y - here->y, here->x - before->x) / length;
          if (slopes.Holds(sample.pixel, kMarginPx)) samples.push_back(std::move(sample));
        }
        since_px = length - (at - kSampleStepPx);
      }
      before = here;
    }
  }

  const Lens& lens_;
  std::span<const MeshEdge> edges_;
  const RayCaster& rays_;
};

// A sample with the step of light that it is to lie on.
struct EdgeMatch {
  std::size_t edge = 0;
  PointMatch match;
  glm::dvec2 normal{0.0};
  double root_weight = 1.0;
};

// Errors across the edges, of a camera that moves from `pose`.
struct NormalErrors {
  int NumResiduals() const { return static_cast<int>(matches.size()); }

  template <typename T>
  [[gnu::flatten]] bool operator()(const T* motion, T* errors) const {
    for (const EdgeMatch& match : matches) {
      const glm::dvec4 point = pose * glm::dvec4(match.match.point_world_m, 1.0);
      const auto moved = MovedPoint<T>(motion, {T(point.x), T(point.y), T(point.z)});
      std::array<T, 2> error;
      if (!PixelError(intrinsics, moved, match.match.pixel, error.data())) return false;
      *errors++ = match.root_weight * (match.normal.x * error[0] + match.normal.y * error[1]);
    }
    return true;
  }

  const CameraIntrinsics& intrinsics;
  std::span<const EdgeMatch> matches;
  glm::dmat4 pose;
};
using NormalErrorsAndJacobian = ceres::TinySolverAutoDiffFunction<NormalErrors, Eigen::Dynamic, 6>;

std::vector<EdgeMatch> MatchesOf(const std::vector<Sample>& samples, double scale_px) {
  std::vector<EdgeMatch> matches;
  for (const Sample& sample : samples) {
    const double nearest = sample.NearestPx();
    if (!std::isfinite(nearest)) continue;
    EdgeMatch match;
    match.edge = sample.edge;
    match.match = {sample.point_m, sample.pixel + nearest * sample.normal};
    match.normal = sample.normal;
    // Geman and McClure's loss: the influence of distant samples decreases.
    const double ratio = nearest / scale_px;
    match.root_weight = 1.0 / (1.0 + ratio * ratio);
    matches.push_back(match);
  }
  return matches;
}

struct Stage {
  double reach_px;
  double scale_px;  // Scale of the weights.
  int rounds;
  double hold = 0.0;  // Root of the weight by which samples stay where the rough pose puts them.
  std::size_t samples = kFewSamples;
};

// The pose moved by rounds of matching and least squares; none where too little is in view.
std::optional<glm::dmat4> Moved(const EdgeView& view,
                                const Slopes& slopes,
                                const Stage& stage,
                                const glm::dmat4& rough,
                                glm::dmat4 pose) {
  for (int round = 0; round < stage.rounds; ++round) {
    std::vector<Sample> samples = view.SamplesOf(pose, slopes, stage.samples);
    for (Sample& sample : samples) sample.steps_px = StepsAlong(slopes, sample, stage.reach_px);
    std::vector<EdgeMatch> matches = MatchesOf(samples, stage.scale_px);
    if (matches.size() < kFewestSamples / 2) return std::nullopt;
    for (const Sample& sample : samples) {
      const auto before = view.Project(rough, sample.point_m);
      if (!(stage.hold > 0.0) || !before) continue;
      for (const glm::dvec2& axis : {glm::dvec2(1.0, 0.0), glm::dvec2(0.0, 1.0)}) {
        matches.push_back({sample.edge, {sample.point_m, *before}, axis, stage.hold});
      }
    }
    const NormalErrors errors{view.Intrinsics(), matches, pose};
    ceres::TinySolver<NormalErrorsAndJacobian> solver;
    solver.options.max_num_iterations = 2;  // One step: matches change anyway.
    Motion motion = Motion::Zero();
    solver.Solve(NormalErrorsAndJacobian(errors), &motion);
    if (!motion.allFinite()) return std::nullopt;
    pose = MovedPose(pose, motion);
    constexpr double kStands = 1e-5;  // Radians and metres: below 0.01 px.
    if (motion.norm() < kStands) break;
  }
  return pose;
}

// By how far the edges in the picture of the one pose are elsewhere in that of the other: the
// median sample.
double ShiftPx(const EdgeView& view,
               const Slopes& slopes,
               const glm::dmat4& from,
               const glm::dmat4& to) {
  std::vector<double> shifts;
  for (const Sample& sample : view.SamplesOf(from, slopes)) {
    const auto there = view.Project(to, sample.point_m);
    shifts.push_back(there ? glm::distance(sample.pixel, *there)
                           : std::numeric_limits<double>::infinity());
  }
  return UpperMedian(shifts);
}

// How much of the mesh's edges the picture has, each sample by how near.
double Support(const EdgeView& view, const Slopes& slopes, const glm::dmat4& pose) {
  std::vector<Sample> samples = view.SamplesOf(pose, slopes);
  if (samples.size() < kFewestSamples) return 0.0;
  double sum = 0.0;
  for (Sample& sample : samples) {
    sample.steps_px = StepsAlong(slopes, sample, 2.0 * kNearPx);
    const double nearest = sample.NearestPx() / kSharpPx;
    if (std::isfinite(nearest)) sum += std::exp(-nearest * nearest);
  }
  return sum / static_cast<double>(samples.size());
}

glm::dmat4 Turned(const glm::dmat4& pose, double pan_rad, double tilt_rad) {
  Motion motion = Motion::Zero();
  motion[0] = tilt_rad;
  motion[1] = pan_rad;
  return MovedPose(pose, motion);
}

// The group of a match.
struct EdgeGroup {
  std::size_t number = 0;  // From 0.
  // Direction of the match's normal in terms of the group's: 1 or -1. A normal follows the order of
  // its edge's ends, so parallel edges of one group may have opposite ones.
  double sign = 1.0;
};

// Groups matches whose edges are displaced together: those of one edge of the mesh, and those of
// parallel edges next to each other in the picture, which match the same step of light.
std::vector<EdgeGroup> GroupsOf(const std::vector<EdgeMatch>& matches) {
  struct Group {
    glm::dvec2 normal;
    double low;  // Where it reaches along itself.
    double high;
    glm::dvec2 middle;
  };
  std::vector<Group> groups;
  std::vector<EdgeGroup> group_of;
  group_of.reserve(matches.size());
  std::size_t first = 0;
  const auto known_like = [&](const Group& edge) {
    constexpr double kParallel = 0.995;  // The cosine of 6 deg.
    return std::find_if(groups.begin(), groups.end(), [&](const Group& group) {
      const glm::dvec2 along(-group.normal.y, group.normal.x);
      const double there = glm::dot(edge.middle, along);
      return std::abs(glm::dot(edge.normal, group.normal)) > kParallel &&
             std::abs(glm::dot(edge.middle - group.middle, group.normal)) < 2.0 * kNearPx &&
             there > group.low && there < group.high;
    });
  };
  while (first < matches.size()) {
    // Samples of one edge follow one another.
    std::size_t end = first;
    glm::dvec2 sum(0.0);
    for (; end < matches.size() && matches[end].edge == matches[first].edge; ++end) {
      sum += matches[end].match.pixel;
    }
    Group edge{matches[first].normal, 0.0, 0.0, sum / static_cast<double>(end - first)};
    const glm::dvec2 along(-edge.normal.y, edge.normal.x);
    edge.low = glm::dot(matches[first].match.pixel, along);
    edge.high = glm::dot(matches[end - 1].match.pixel, along);
    if (edge.low > edge.high) std::swap(edge.low, edge.high);
    const auto like = known_like(edge);
    const auto number = static_cast<std::size_t>(like - groups.begin());
    if (like == groups.end()) groups.push_back(edge);
    const double sign = glm::dot(edge.normal, groups[number].normal) < 0.0 ? -1.0 : 1.0;
    group_of.insert(group_of.end(), end - first, {number, sign});
    first = end;
  }
  return group_of;
}

// The covariance of the camera's motion. The model: each group of edges is displaced along its
// normal by an amount of its own, mesh_sigma_m in the world, over its complete length; samples
// scatter about that. The distance of groups from the picture's edges, over what the model expects
// of a pose that is fitted to them, corrects mesh_sigma_m.
Eigen::Matrix<double, 6, 6> CovarianceOf(const EdgeView& view,
                                         const std::vector<EdgeMatch>& matches,
                                         const glm::dmat4& pose,
                                         double mesh_sigma_m) {
  const NormalErrors errors{view.Intrinsics(), matches, pose};
  const int count = errors.NumResiduals();
  Eigen::VectorXd residuals(count);
  Eigen::Matrix<double, Eigen::Dynamic, 6> jacobian(count, 6);
  const Motion none = Motion::Zero();
  const NormalErrorsAndJacobian linearise(errors);
  linearise(none.data(), residuals.data(), jacobian.data());
  const Eigen::Matrix<double, 6, 6> inverse =
      (jacobian.transpose() * jacobian).fullPivLu().inverse();

  const std::vector<EdgeGroup> group_of = GroupsOf(matches);
  Eigen::Index groups = 0;
  for (const EdgeGroup& group : group_of) {
    groups = std::max(groups, static_cast<Eigen::Index>(group.number + 1));
  }
  // For each group: the change of the normal equations' right side when the group is displaced by
  // one deviation, and the group's mean residual in deviations.
  Eigen::Matrix<double, 6, Eigen::Dynamic> pulls(6, groups);
  Eigen::Matrix<double, Eigen::Dynamic, 6> means(groups, 6);
  Eigen::VectorXd mean_residual(groups);
  Eigen::VectorXd sizes(groups);
  Eigen::VectorXd offsets(count);
  pulls.setZero();
  means.setZero();
  mean_residual.setZero();
  sizes.setZero();
  // Of a picture's edge, whatever the mesh: blur, and the threshold between what it separates.
  constexpr double kPictureSigmaPx = 0.1;
  for (int i = 0; i < count; ++i) {
    const EdgeMatch& match = matches[static_cast<std::size_t>(i)];
    const double depth_m = (pose * glm::dvec4(match.match.point_world_m, 1.0)).z;
    const EdgeGroup& of = group_of[static_cast<std::size_t>(i)];
    // Along the group's normal: displacements of opposite normals must not cancel.
    const double offset_px =
        of.sign * match.root_weight *
        std::hypot(mesh_sigma_m * view.Intrinsics().fx_px / depth_m, kPictureSigmaPx);
    const auto group = static_cast<Eigen::Index>(of.number);
    offsets[i] = offset_px;
    pulls.col(group) += jacobian.row(i).transpose() * offset_px;
    means.row(group) += jacobian.row(i) / offset_px;
    mean_residual[group] += residuals[i] / offset_px;
    sizes[group] += 1.0;
  }
  for (Eigen::Index group = 0; group < groups; ++group) {
    means.row(group) /= sizes[group];
    mean_residual[group] /= sizes[group];
  }
  // The part of each group's displacement that remains in each group's mean residual once the pose
  // is fitted. Groups count by their samples.
  const Eigen::MatrixXd left = Eigen::MatrixXd::Identity(groups, groups) - means * inverse * pulls;
  const double one_group = sizes.squaredNorm() / sizes.sum();
  const double expected = sizes.dot(left.rowwise().squaredNorm()) / one_group;
  const double found = sizes.dot(mean_residual.array().square().matrix()) / one_group;
  // The stated deviation counts as much as one group.
  constexpr double kStatedGroups = 1.0;
  const double freedom = kStatedGroups + expected;
  const double scale = (kStatedGroups + found) / freedom;
  // A scale that few groups give is itself uncertain, as Student's t is wider than a normal error.
  const double few = freedom / (freedom - std::min(1.0, 0.5 * freedom));
  double squares = 0.0;
  for (int i = 0; i < count; ++i) {
    const auto group = static_cast<Eigen::Index>(group_of[static_cast<std::size_t>(i)].number);
    const double about = residuals[i] - mean_residual[group] * offsets[i];
    squares += about * about;
  }
  const double variance = squares / std::max(1.0, static_cast<double>(count - groups));
  const Eigen::Matrix<double, 6, 6> by_groups =
      inverse * (pulls * pulls.transpose()) * inverse * (few * scale);
  return by_groups + variance * inverse;
}

}  // namespace

void EdgePoseOptions::Validate() const {
  const auto require = [](bool good, const char* field, double value, const char* expected) {
    if (good) return;
    throw std::invalid_argument(std::string(field) + ": expected " + expected + ", found " +
                                NumberText("%g", value));
  };
  require(reach_px > 1.0 && std::isfinite(reach_px), "reach_px", reach_px, "above 1");
  require(mesh_sigma_m >= 0.0 && std::isfinite(mesh_sigma_m),
          "mesh_sigma_m",
          mesh_sigma_m,
          "0 or more");
  require(largest_rotation_sigma_rad > 0.0,
          "largest_rotation_sigma_rad",
          largest_rotation_sigma_rad,
          "above 0");
  require(largest_position_sigma_m > 0.0,
          "largest_position_sigma_m",
          largest_position_sigma_m,
          "above 0");
}

tl::expected<EdgePose, UndeterminedPose> RefinePoseByEdges(
    const Lens& lens,
    const Rgb8Image& picture,
    std::span<const MeshEdge> edges,
    const RayCaster& rays,
    const glm::dmat4& rough_camera_from_world,
    const EdgePoseOptions& options) {
  options.Validate();
  const CameraIntrinsics& intrinsics = lens.Intrinsics();
  if (picture.width != intrinsics.width_px || picture.height != intrinsics.height_px) {
    throw std::invalid_argument("picture: expected " + std::to_string(intrinsics.width_px) + "x" +
                                std::to_string(intrinsics.height_px) + " pixels, found " +
                                std::to_string(picture.width) + "x" +
                                std::to_string(picture.height));
  }
  const EdgeView view(lens, edges, rays);
  const Slopes coarse(picture, 2.5);
  const Slopes fine(picture, 1.0);
  const double reach = options.reach_px;
  if (view.SamplesOf(rough_camera_from_world, fine).size() < kFewestSamples) {
    return tl::unexpected(
        OpenPose("the rough pose has hardly an edge of the mesh in view, expected some that are " +
                 NumberText("%.0f px long together", kFewestSamples * kSampleStepPx)));
  }

  // Starts turned so that the picture shifts by up to the reach.
  struct Try {
    glm::dmat4 pose;
    double support;
  };
  std::vector<Try> tries;
  // From each start, edges are searched over the entire reach, and also only nearby. A wide search
  // goes to the strongest edges, a narrow one to those that fit best.
  const std::vector<Stage> wide{{reach, 0.3 * reach, 6, 0.3},
                                {0.5 * reach, 0.15 * reach, 6, 0.15},
                                {0.3 * reach, kNearPx, 6, 0.05}};
  const std::vector<Stage> narrow{{0.5 * reach, kNearPx, 8, 0.1}};
  for (const double pan : {0.0, -0.4, 0.4, -0.8, 0.8}) {
    for (const double tilt : {0.0, -0.4, 0.4, -0.8, 0.8}) {
      for (const std::vector<Stage>* stages : {&wide, &narrow}) {
        std::optional<glm::dmat4> pose = Turned(rough_camera_from_world,
                                                pan * reach / intrinsics.fx_px,
                                                tilt * reach / intrinsics.fy_px);
        for (const Stage& stage : *stages) {
          if (pose) pose = Moved(view, coarse, stage, rough_camera_from_world, *pose);
        }
        if (pose) pose = Moved(view, fine, {6.0, kNearPx, 8}, rough_camera_from_world, *pose);
        if (pose) tries.push_back({*pose, Support(view, fine, *pose)});
      }
    }
  }
  std::stable_sort(
      tries.begin(), tries.end(), [](const Try& a, const Try& b) { return a.support > b.support; });
  std::optional<glm::dmat4> best;
  if (!tries.empty()) {
    best = Moved(view,
                 fine,
                 {4.0, 0.5 * kNearPx, 30, 0.0, kMostSamples},
                 rough_camera_from_world,
                 tries[0].pose);
  }
  if (!best) {
    return tl::unexpected(OpenPose("the picture has too few edges near those of the mesh"));
  }
  EdgePose result;
  result.camera_from_world = *best;
  std::vector<Sample> samples = view.SamplesOf(*best, fine);
  std::vector<Sample> counting;
  double squares = 0.0;
  double others_per_px = 0.0;
  constexpr double kFarPx = 16.0;
  for (Sample& sample : samples) {
    sample.steps_px = StepsAlong(fine, sample, kFarPx);
    for (const double step : sample.steps_px) {
      if (std::abs(step) > 2.0 * kNearPx) others_per_px += 1.0 / (2.0 * (kFarPx - 2.0 * kNearPx));
    }
    const double nearest = sample.NearestPx();
    const bool counts = std::abs(nearest) <= kNearPx;
    result.samples.push_back({sample.pixel, sample.normal, nearest, counts});
    if (!counts) continue;
    squares += nearest * nearest;
    counting.push_back(sample);
  }
  const double count = static_cast<double>(samples.size());
  if (samples.size() < kFewestSamples || counting.size() < kFewestSamples / 2) {
    return tl::unexpected(OpenPose("hardly an edge of the mesh is found in the picture"));
  }
  result.rms_px = std::sqrt(squares / static_cast<double>(counting.size()));
  result.found_share = static_cast<double>(counting.size()) / count;
  result.chance_share = 1.0 - std::exp(-2.0 * kNearPx * others_per_px / count);
  const PoseCandidate candidate{*best, result.rms_px};
  const std::string found = NumberText("%.0f %%", 100.0 * result.found_share) +
                            " of the mesh's edges are found in the picture, where chance finds " +
                            NumberText("%.0f %%", 100.0 * result.chance_share) +
                            " (reprojection error " + NumberText("%.2f px", result.rms_px) + ")";
  if (!(result.found_share >= result.chance_share + kLeastShareOverChance)) {
    return tl::unexpected(OpenPose(found, {candidate}));
  }
  const Eigen::Matrix<double, 6, 6> covariance =
      CovarianceOf(view, MatchesOf(counting, 0.5 * kNearPx), *best, options.mesh_sigma_m);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> of_rotation(
      Eigen::Matrix3d(covariance.topLeftCorner<3, 3>()), Eigen::EigenvaluesOnly);
  result.rotation_sigma_rad = std::sqrt(of_rotation.eigenvalues()[2]);
  result.position_sigma_m = std::sqrt(covariance.bottomRightCorner<3, 3>().trace());
  for (int axis = 0; axis < 3; ++axis) {
    result.axis_rotation_sigma_rad[axis] = std::sqrt(covariance(axis, axis));
    result.axis_position_sigma_m[axis] = std::sqrt(covariance(3 + axis, 3 + axis));
  }
  if (!(result.rotation_sigma_rad <= options.largest_rotation_sigma_rad &&
        result.position_sigma_m <= options.largest_position_sigma_m)) {
    return tl::unexpected(
        OpenPose("the edges leave it open to " +
                     NumberText("%.2f deg", DegFromRad(result.rotation_sigma_rad)) + " and " +
                     NumberText("%.2f m", result.position_sigma_m) + "; " + found,
                 {candidate}));
  }
  const double shift_px = ShiftPx(view, fine, rough_camera_from_world, *best);
  if (!(shift_px <= 1.5 * reach)) {
    return tl::unexpected(OpenPose("the best pose moves the mesh's edges by " +
                                   PixelText(shift_px) + ", expected at most " +
                                   PixelText(1.5 * reach)));
  }
  for (const Try& other : tries) {
    if (!(other.support >= kRivalShare * tries[0].support)) break;
    const double apart_px = ShiftPx(view, fine, *best, other.pose);
    if (apart_px <= 2.0 * kNearPx) continue;
    return tl::unexpected(OpenPose("two poses fit the edges nearly as well, with the picture " +
                                       PixelText(apart_px) + " apart",
                                   {{*best, 0.0}, {other.pose, 0.0}}));
  }
  return result;
}

}  // namespace pleinair
