#include "calib/pose_correction.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>
#include <vector>

#include <Eigen/Dense>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "calib/internal/edge_view.h"
#include "calib/internal/reprojection.h"
#include "calib/internal/residual_text.h"

namespace pleinair {
namespace {

using Information = Eigen::Matrix<double, 6, 6>;

constexpr std::size_t kMostPlaces = 240;
constexpr std::size_t kFewestPlaces = 40;
// Of a picture's edge, whatever the mesh: blur, texture, and the threshold between two surfaces.
constexpr double kPictureSigmaPx = 0.7;
// Share of places whose nearest step of light is not the mesh's edge: a shadow's, a window's.
constexpr double kOtherShare = 0.3;
// That a stated pose is off by some pixels, against its being right to a fraction of one, before
// the pictures are looked at: three to one. An assumption.
const double kLogOddsBeforehand = std::log(3.0);
// The mesh's edges that the camera shows most of: enough for a pose, however fine the mesh.
constexpr std::size_t kMostEdges = 300;

// A rotation vector and a translation that move `from` to `to`: MovedPose(from, result) is `to`.
Motion MotionBetween(const glm::dmat4& from, const glm::dmat4& to) {
  const glm::dmat4 moved = to * glm::inverse(from);
  Motion motion;
  std::array<double, 9> rotation{};
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) {
      rotation[static_cast<std::size_t>(3 * column + row)] = moved[column][row];
    }
  }
  ceres::RotationMatrixToAngleAxis(rotation.data(), motion.data());
  for (int row = 0; row < 3; ++row) motion[3 + row] = moved[3][row];
  return motion;
}

// How far a mesh's edges may be off, standard deviations: surveyed, drawn by hand, guessed.
constexpr double kMeshSigmasM[] = {0.01, 0.03, 0.09};

// A step of the search.
struct SearchStep {
  double mesh_sigma_m;
  double reach_px;
  double loosened;  // Factor on the deviations of edges, while the pose is far.
};

// Log posterior of a pose, and its quadratic approximation in the camera's motion.
struct Posterior {
  double log_density = 0.0;
  Information information = Information::Zero();
  Motion gradient = Motion::Zero();
  double found_share = 0.0;   // Of the edges, in the pictures within kNearPx.
  double chance_share = 0.0;  // Expected of the pictures' other edges.
};

// Where the pictures' nearest steps of light are, for each place that a pose puts edges.
struct Matches {
  std::vector<EdgeMatch> matches;  // Those of one edge follow one another.
  std::vector<bool> is_found;      // False: no step is within reach, and the match is the place's.
};

class PoseEvidence {
 public:
  PoseEvidence(const EdgeView& view,
               std::span<const PictureSlopes> pictures,
               const glm::dmat4& stated,
               const PoseCorrectionOptions& options,
               double reach_px)
      : view_(view), pictures_(pictures), stated_(stated) {
    double steps = 0.0;
    double searched_px = 0.0;
    for (const EdgePlace& place : view.PlacesOf(stated, pictures.front(), kMostPlaces)) {
      for (const PictureSlopes& slopes : pictures) {
        steps += static_cast<double>(StepsAlong(slopes, place, reach_px).size());
        searched_px += 2.0 * reach_px;
      }
    }
    steps_per_px_ = steps / std::max(searched_px, 1.0);
    sigmas_.head<3>().setConstant(options.rotation_sigma_rad);
    sigmas_.tail<3>().setConstant(options.position_sigma_m);
  }

  Information Prior() const { return sigmas_.cwiseInverse().cwiseAbs2().asDiagonal(); }

  Posterior At(const glm::dmat4& pose, const SearchStep& step) const {
    Posterior posterior;
    const Motion from_stated = MotionBetween(stated_, pose).cwiseQuotient(sigmas_);
    posterior.log_density = -0.5 * from_stated.squaredNorm();
    posterior.information = Prior();
    posterior.gradient = -from_stated.cwiseQuotient(sigmas_);

    const auto [matches, is_found] = MatchesAt(pose, step.reach_px);
    const std::vector<double> shares = SharesOf(matches);
    double all_shares = 0.0;
    const auto [residuals, jacobian] = Linearised(NormalErrors{view_.Intrinsics(), matches, pose});
    for (std::size_t i = 0; i < matches.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      const double depth_m = (pose * glm::dvec4(matches[i].match.point_world_m, 1.0)).z;
      const double sigma_px =
          step.loosened *
          std::hypot(step.mesh_sigma_m * view_.Intrinsics().fx_px / depth_m, kPictureSigmaPx);
      // The step is the mesh's edge, or another one that is anywhere.
      const double off = residuals[row] / sigma_px;
      all_shares += shares[i];
      if (is_found[i] && std::abs(residuals[row]) <= kNearPx) posterior.found_share += shares[i];
      const double mine = is_found[i] ? std::exp(-0.5 * off * off) : 0.0;
      const double other = kOtherShare / (1.0 - kOtherShare) * steps_per_px_ * sigma_px *
                           std::sqrt(2.0 * std::numbers::pi);
      posterior.log_density += shares[i] * std::log((mine + other) / sigma_px);
      const double weight = shares[i] * mine / (mine + other) / (sigma_px * sigma_px);
      posterior.information += weight * jacobian.row(row).transpose() * jacobian.row(row);
      posterior.gradient -= weight * residuals[row] * jacobian.row(row).transpose();
    }
    posterior.found_share /= std::max(all_shares, 1.0);
    posterior.chance_share = 1.0 - std::exp(-2.0 * kNearPx * steps_per_px_);
    return posterior;
  }

 private:
  Matches MatchesAt(const glm::dmat4& pose, double reach_px) const {
    Matches found;
    // Where edges are does not depend on the picture.
    for (EdgePlace& place : view_.PlacesOf(pose, pictures_.front(), kMostPlaces)) {
      for (const PictureSlopes& slopes : pictures_) {
        place.steps_px = StepsAlong(slopes, place, reach_px);
        const double nearest = place.NearestPx();
        const bool is_found = std::isfinite(nearest);
        const glm::dvec2 pixel = place.pixel + (is_found ? nearest : 0.0) * place.normal;
        found.matches.push_back({place.edge, {place.point_m, pixel}, place.normal});
        found.is_found.push_back(is_found);
      }
    }
    return found;
  }

  // How much each match counts. An edge is displaced as a whole, in all pictures alike, each of its
  // ends by itself: however many matches it has, it is no more than two measurements.
  static std::vector<double> SharesOf(const std::vector<EdgeMatch>& matches) {
    constexpr double kMeasurementsAnEdge = 2.0;
    const std::vector<EdgeGroup> group_of = GroupsOf(matches);
    std::vector<double> sizes;
    for (const EdgeGroup& group : group_of) {
      sizes.resize(std::max(sizes.size(), group.number + 1), 0.0);
      sizes[group.number] += 1.0;
    }
    std::vector<double> shares;
    for (const EdgeGroup& group : group_of) {
      shares.push_back(std::min(1.0, kMeasurementsAnEdge / sizes[group.number]));
    }
    return shares;
  }

  const EdgeView& view_;
  std::span<const PictureSlopes> pictures_;
  glm::dmat4 stated_;
  double steps_per_px_ = 0.0;  // Of all of the pictures' steps of light, along the places' normals.
  Motion sigmas_;
};

// The edges that the camera shows most of, at most kMostEdges; those of a fine mesh would take
// long.
std::vector<MeshEdge> MainEdges(const Lens& lens,
                                std::span<const MeshEdge> edges,
                                const RayCaster& rays,
                                const PictureSlopes& slopes,
                                const glm::dmat4& pose) {
  if (edges.size() <= kMostEdges) return {edges.begin(), edges.end()};
  std::vector<std::size_t> places(edges.size(), 0);
  const EdgeView all(lens, edges, rays);
  for (const EdgePlace& place : all.PlacesOf(pose, slopes, 20 * kMostPlaces)) ++places[place.edge];
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (places[i] > 0) order.push_back(i);
  }
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return places[a] > places[b];
  });
  order.resize(std::min(order.size(), kMostEdges));
  std::vector<MeshEdge> main;
  for (const std::size_t index : order) main.push_back(edges[index]);
  return main;
}

// What the deviation of a pose moves the edges' places in the picture by, root mean square.
double ShiftSigmaPx(const EdgeView& view,
                    const PictureSlopes& slopes,
                    const glm::dmat4& pose,
                    const Information& covariance) {
  std::vector<EdgeMatch> places;
  for (const EdgePlace& place : view.PlacesOf(pose, slopes, kMostPlaces)) {
    for (const glm::dvec2& axis : {glm::dvec2(1.0, 0.0), glm::dvec2(0.0, 1.0)}) {
      places.push_back({place.edge, {place.point_m, place.pixel}, axis});
    }
  }
  if (places.empty()) return 0.0;
  const auto jacobian = Linearised(NormalErrors{view.Intrinsics(), places, pose}).jacobian;
  const double sum = (jacobian * covariance).cwiseProduct(jacobian).sum();
  return std::sqrt(2.0 * sum / static_cast<double>(places.size()));
}

}  // namespace

void PoseCorrectionOptions::Validate() const {
  const auto require = [](bool good, const char* field, double value, const char* expected) {
    if (good) return;
    throw std::invalid_argument(std::string(field) + ": expected " + expected + ", found " +
                                NumberText("%g", value));
  };
  const auto above_0 = [](double value) { return value > 0.0 && std::isfinite(value); };
  require(above_0(rotation_sigma_rad), "rotation_sigma_rad", rotation_sigma_rad, "above 0");
  require(above_0(position_sigma_m), "position_sigma_m", position_sigma_m, "above 0");
  require(least_shift_px >= 0.0 && std::isfinite(least_shift_px),
          "least_shift_px",
          least_shift_px,
          "0 or more");
  const double reach = reach_px.value_or(2.0);
  require(reach > 1.0 && std::isfinite(reach), "reach_px", reach, "above 1");
}

PoseCorrection CorrectPoseByEdges(const Lens& lens,
                                  std::span<const Rgb8Image> pictures,
                                  std::span<const MeshEdge> edges,
                                  const RayCaster& rays,
                                  const glm::dmat4& stated,
                                  const PoseCorrectionOptions& options) {
  options.Validate();
  const CameraIntrinsics& intrinsics = lens.Intrinsics();
  if (pictures.empty()) throw std::invalid_argument("pictures: expected at least one");
  std::vector<PictureSlopes> coarse;
  std::vector<PictureSlopes> fine;
  for (const Rgb8Image& picture : pictures) {
    if (picture.width != intrinsics.width_px || picture.height != intrinsics.height_px) {
      throw std::invalid_argument("pictures: expected " + std::to_string(intrinsics.width_px) +
                                  "x" + std::to_string(intrinsics.height_px) + " pixels, found " +
                                  std::to_string(picture.width) + "x" +
                                  std::to_string(picture.height));
    }
    coarse.emplace_back(picture, 2.0);
    fine.emplace_back(picture, 1.0);
  }
  const std::vector<MeshEdge> main = MainEdges(lens, edges, rays, fine.front(), stated);
  const EdgeView view(lens, main, rays);
  const double reach_px = options.reach_px.value_or(intrinsics.width_px / 60.0);
  const PoseEvidence rough_evidence(view, coarse, stated, options, reach_px);
  const PoseEvidence evidence(view, fine, stated, options, reach_px);
  PoseCorrection result;
  result.camera_from_world = stated;
  if (view.PlacesOf(stated, fine.front(), kMostPlaces).size() < kFewestPlaces) {
    result.reason = "hardly an edge of the mesh is in view";
    return result;
  }
  const auto last = [&](double mesh_sigma_m) {
    return SearchStep{mesh_sigma_m, 0.5 * reach_px, 1.0};
  };
  const auto moved = [&](glm::dmat4 pose, const PoseEvidence& by, const SearchStep& step) {
    constexpr int kRounds = 5;
    for (int round = 0; round < kRounds; ++round) {
      const Posterior at = by.At(pose, step);
      pose = MovedPose(pose, at.information.ldlt().solve(at.gradient));
    }
    return pose;
  };
  // Starts that are turned by less than the reach; the posterior decides between their ends.
  constexpr double kUsualMeshM = kMeshSigmasM[1];
  glm::dmat4 best = stated;
  double best_density = evidence.At(stated, last(kUsualMeshM)).log_density;
  for (const double pan : {0.0, -0.4, 0.4}) {
    for (const double tilt : {0.0, -0.4, 0.4}) {
      Motion turn = Motion::Zero();
      turn[0] = tilt * reach_px / intrinsics.fy_px;
      turn[1] = pan * reach_px / intrinsics.fx_px;
      glm::dmat4 pose = MovedPose(stated, turn);
      pose = moved(pose, rough_evidence, {kUsualMeshM, reach_px, 3.0});
      pose = moved(pose, rough_evidence, {kUsualMeshM, 0.7 * reach_px, 1.7});
      pose = moved(pose, evidence, last(kUsualMeshM));
      const double density = evidence.At(pose, last(kUsualMeshM)).log_density;
      if (density > best_density) {
        best = pose;
        best_density = density;
      }
    }
  }
  // Laplace's approximation of the evidences: a pose that may be off explains more pictures, so it
  // must explain these better. Each with the mesh that suits it best.
  const double prior_determinant = evidence.Prior().determinant();
  double log_exact = -std::numeric_limits<double>::infinity();
  double log_off = log_exact;
  const glm::dmat4 usual = best;
  Posterior of_best;
  for (const double mesh_sigma_m : kMeshSigmasM) {
    log_exact = std::max(log_exact, evidence.At(stated, last(mesh_sigma_m)).log_density);
    const glm::dmat4 pose = moved(usual, evidence, last(mesh_sigma_m));
    const Posterior at = evidence.At(pose, last(mesh_sigma_m));
    const double log_evidence =
        at.log_density - 0.5 * std::log(at.information.determinant() / prior_determinant);
    if (!(log_evidence > log_off)) continue;
    log_off = log_evidence;
    best = pose;
    of_best = at;
    result.mesh_sigma_m = mesh_sigma_m;
  }
  result.log_odds = kLogOddsBeforehand + log_off - log_exact;
  result.found_share = of_best.found_share;
  result.chance_share = of_best.chance_share;
  result.shift_px = ShiftPx(view, fine.front(), stated, best);
  result.shift_sigma_px = ShiftSigmaPx(view, fine.front(), best, of_best.information.inverse());
  if (!(of_best.found_share >= of_best.chance_share + kLeastShareOverChance)) {
    result.reason = NumberText("%.0f %%", 100.0 * of_best.found_share) +
                    " of the mesh's edges are found in the pictures, where chance finds " +
                    NumberText("%.0f %%", 100.0 * of_best.chance_share);
    return result;
  }
  if (!(result.log_odds > 0.0)) {
    result.reason = "the edges in the pictures agree with it";
    return result;
  }
  if (!(result.shift_px >= options.least_shift_px)) {
    result.reason = "the edges in the pictures are less than " + PixelText(options.least_shift_px) +
                    " from where it puts them";
    return result;
  }
  result.corrected = true;
  result.camera_from_world = best;
  return result;
}

}  // namespace pleinair
