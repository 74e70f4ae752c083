#include "calib/pose_correction.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include <Eigen/Dense>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "calib/internal/check_number.h"
#include "calib/internal/edge_adjustment.h"
#include "calib/internal/edge_view.h"
#include "calib/internal/reprojection.h"
#include "calib/internal/residual_text.h"

namespace pleinair {
namespace {

using Information = Eigen::Matrix<double, 6, 6>;
using Covariance = Information;

constexpr std::size_t kMostJudgedPlaces = 240;
// Places among which these are chosen, so that hidden ones do not use them up.
constexpr std::size_t kMostVisiblePlaces = 20 * kMostJudgedPlaces;
// Of one place in the picture, whatever the mesh: blur, texture, and the threshold between two
// surfaces.
constexpr double kPlaceSigmaPx = 0.7;
// Share of places whose nearest step of light is not the mesh's edge: a shadow's, a window's.
constexpr double kOtherShare = 0.3;
// A picture with less than this share of the steps of the one that has most is left out: night,
// fog.
constexpr double kFewSteps = 0.5;
// How far a mesh's edges may be off, standard deviations: surveyed, drawn by hand, guessed.
constexpr double kMeshSigmasM[] = {0.01, 0.03, 0.09};
// A pose farther from the stated one than its deviations allow is another edge's: the 0.9999
// quantile of chi-squared with six degrees of freedom.
constexpr double kMostSquaredSigmas = 27.9;

// Less than kLeastShareOverChance: the odds say, too, whether the edges are the mesh's. Of a mesh
// that is 6 cm off many edges are not found near where a good pose puts them.
constexpr double kLeastFoundOverChance = 0.15;

// A step of the search.
struct SearchStep {
  double mesh_sigma_m;
  double reach_px;
  double loosened;  // Factor on the deviations of edges, while the pose is far.
};

// Log posterior of a pose, and its quadratic approximation in the camera's motion, with the weights
// that the pose gives (not its second derivative: deviations are a little too small).
struct Posterior {
  double log_density = 0.0;
  Information information = Information::Zero();
  Motion gradient = Motion::Zero();
  double found_share = 0.0;  // Of the edges, in the pictures within kNearPx.
};

// Places, and how much one picture's match of each counts.
struct JudgedPlaces {
  std::vector<FixedPlace> places;
  std::vector<double> shares;
};

// The places that all poses are judged by: those of another pose could be fewer, and so better.
JudgedPlaces JudgedPlacesOf(const EdgeView& view,
                            std::span<const MeshEdge> edges,
                            const PictureSlopes& picture,
                            const glm::dmat4& stated,
                            std::size_t pictures) {
  const std::vector<EdgePlace> visible = view.PlacesOf(stated, picture, kMostVisiblePlaces);
  const std::size_t count = std::min(visible.size(), kMostJudgedPlaces);
  JudgedPlaces judged;
  std::vector<EdgeMatch> matches;
  for (std::size_t i = 0; i < count; ++i) {
    const EdgePlace& place = visible[i * visible.size() / count];
    const MeshEdge& edge = edges[place.edge];
    judged.places.push_back({place.edge, place.point_m, glm::normalize(edge.to_m - edge.from_m)});
    matches.push_back({place.edge, {place.point_m, place.pixel}, place.normal});
  }
  // An edge is displaced as a whole, in all pictures alike, each of its ends by itself: however
  // many places it has, it is no more than two measurements.
  constexpr double kMeasurementsAnEdge = 2.0;
  const std::vector<EdgeGroup> group_of = GroupsOf(matches);
  std::vector<double> sizes;
  for (const EdgeGroup& group : group_of) {
    sizes.resize(std::max(sizes.size(), group.number + 1), 0.0);
    sizes[group.number] += static_cast<double>(pictures);
  }
  for (std::size_t i = 0; i < count; ++i) {
    judged.shares.push_back(std::min(1.0, kMeasurementsAnEdge / sizes[group_of[i].number]));
  }
  return judged;
}

PosePrior PriorOf(const glm::dmat4& stated, const PoseCorrectionOptions& options) {
  PosePrior prior{stated, {}};
  prior.sigmas.head<3>().setConstant(options.rotation_sigma_rad);
  prior.sigmas.tail<3>().setConstant(options.position_sigma_m);
  return prior;
}

class PoseEvidence {
 public:
  // Keeps references to view, pictures and judged.
  PoseEvidence(const EdgeView& view,
               std::span<const PictureSlopes* const> pictures,
               const JudgedPlaces& judged,
               const PosePrior& prior,
               double reach_px)
      : view_(view), pictures_(pictures), judged_(judged), prior_(prior) {
    double steps = 1.0;  // One more, so that none is not impossible.
    double searched_px = 1.0;
    for (const FixedPlace& place : judged.places) {
      const auto here = PlaceAt(view, *pictures.front(), place, prior.pose);
      if (!here) continue;
      for (const PictureSlopes* slopes : pictures) {
        steps += static_cast<double>(StepsAlong(*slopes, *here, reach_px).size());
        searched_px += 2.0 * reach_px;
      }
    }
    steps_per_px_ = steps / searched_px;
  }

  Information Prior() const { return prior_.sigmas.cwiseInverse().cwiseAbs2().asDiagonal(); }
  double SquaredSigmas(const glm::dmat4& pose) const {
    return MotionBetween(prior_.pose, pose).cwiseQuotient(prior_.sigmas).squaredNorm();
  }
  double StepsPerPx() const { return steps_per_px_; }
  // Share of edges that a picture's other edges are near, by chance.
  double ChanceShare(double reach_px) const {
    return 1.0 - std::exp(-2.0 * std::min(kNearPx, reach_px) * steps_per_px_);
  }

  Posterior At(const glm::dmat4& pose, const SearchStep& step) const {
    Posterior posterior;
    const Motion from_stated = MotionBetween(prior_.pose, pose).cwiseQuotient(prior_.sigmas);
    posterior.log_density = -0.5 * from_stated.squaredNorm();
    posterior.information = Prior();
    posterior.gradient = -from_stated.cwiseQuotient(prior_.sigmas);

    std::vector<EdgeMatch> matches;  // Those with a step within reach.
    std::vector<double> shares;
    double all_shares = 0.0;
    for (std::size_t i = 0; i < judged_.places.size(); ++i) {
      const FixedPlace& place = judged_.places[i];
      const double share = judged_.shares[i];
      std::optional<EdgePlace> here = PlaceAt(view_, *pictures_.front(), place, pose);
      for (const PictureSlopes* slopes : pictures_) {
        all_shares += share;
        if (here) here->steps_px = StepsAlong(*slopes, *here, step.reach_px);
        const double nearest = here ? here->NearestPx() : std::numeric_limits<double>::infinity();
        if (std::isfinite(nearest)) {
          const glm::dvec2 pixel = here->pixel + nearest * here->normal;
          matches.push_back({place.edge, {place.point_m, pixel}, here->normal});
          shares.push_back(share);
        } else {
          const double sigma_px = SigmaPx(place.point_m, pose, step);
          posterior.log_density += share * std::log(OtherEdges(sigma_px) / sigma_px);
        }
      }
    }
    if (matches.empty()) return posterior;
    const auto [residuals, jacobian] = Linearised(NormalErrors{view_.Intrinsics(), matches, pose});
    const double near_px = std::min(kNearPx, step.reach_px);
    for (std::size_t i = 0; i < matches.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      const double sigma_px = SigmaPx(matches[i].match.point_world_m, pose, step);
      // The step is the mesh's edge, or another one that is anywhere.
      const double off = residuals[row] / sigma_px;
      const double mine = std::exp(-0.5 * off * off);
      const double other = OtherEdges(sigma_px);
      if (std::abs(residuals[row]) <= near_px) posterior.found_share += shares[i];
      posterior.log_density += shares[i] * std::log((mine + other) / sigma_px);
      const double weight = shares[i] * mine / (mine + other) / (sigma_px * sigma_px);
      posterior.information += weight * jacobian.row(row).transpose() * jacobian.row(row);
      posterior.gradient -= weight * residuals[row] * jacobian.row(row).transpose();
    }
    posterior.found_share /= std::max(all_shares, 1e-12);
    return posterior;
  }

 private:
  double SigmaPx(const glm::dvec3& point_m, const glm::dmat4& pose, const SearchStep& step) const {
    const double depth_m = std::max(1e-3, (pose * glm::dvec4(point_m, 1.0)).z);
    return step.loosened *
           std::hypot(step.mesh_sigma_m * view_.Intrinsics().fx_px / depth_m, kPlaceSigmaPx);
  }

  // Likelihood of a step that is not the mesh's edge, over that of one in the edge's place.
  double OtherEdges(double sigma_px) const {
    return kOtherShare / (1.0 - kOtherShare) * steps_per_px_ * sigma_px *
           std::sqrt(2.0 * std::numbers::pi);
  }

  const EdgeView& view_;
  std::span<const PictureSlopes* const> pictures_;
  const JudgedPlaces& judged_;
  PosePrior prior_;
  double steps_per_px_ = 0.0;  // Of all of the pictures' steps of light, along the places' normals.
};

// The pictures that show edges at all.
std::vector<std::size_t> PicturesWithEdges(const EdgeView& view,
                                           std::span<const PictureSlopes> pictures,
                                           const glm::dmat4& stated,
                                           double reach_px) {
  const std::vector<EdgePlace> places = view.PlacesOf(stated, pictures.front(), kMostJudgedPlaces);
  std::vector<double> steps;
  for (const PictureSlopes& slopes : pictures) {
    double& count = steps.emplace_back(0.0);
    for (const EdgePlace& place : places)
      count += StepsAlong(slopes, place, reach_px).empty() ? 0 : 1;
  }
  const double most = *std::max_element(steps.begin(), steps.end());
  std::vector<std::size_t> with_edges;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (steps[i] >= kFewSteps * most) with_edges.push_back(i);
  }
  return with_edges;
}

// Height of what the mesh has below the camera, where heights are measured from there: not on a
// balcony or a slope, below which the mesh goes on.
std::optional<double> GroundBelow(const glm::dmat4& pose,
                                  const RayCaster& rays,
                                  std::span<const MeshEdge> edges) {
  constexpr double kLowerM = 0.3;
  const glm::dvec3 eye(glm::inverse(pose)[3]);
  const auto hit = rays.Intersect(glm::vec3(eye), glm::vec3(0.0f, 0.0f, -1.0f));
  if (!hit) return std::nullopt;
  const double ground_m = hit->position_m.z;
  const bool goes_on_below = std::any_of(edges.begin(), edges.end(), [&](const MeshEdge& edge) {
    return std::min(edge.from_m.z, edge.to_m.z) < ground_m - kLowerM;
  });
  return goes_on_below ? std::nullopt : std::optional(ground_m);
}

// What the deviation of a pose moves points by in the picture, root mean square.
double SigmaPx(const CameraIntrinsics& intrinsics,
               const glm::dmat4& pose,
               const Covariance& covariance,
               std::span<const PointMatch> points) {
  if (points.empty()) return 0.0;
  std::vector<EdgeMatch> along_axes;
  for (const PointMatch& point : points) {
    along_axes.push_back({0, point, glm::dvec2(1.0, 0.0)});
    along_axes.push_back({0, point, glm::dvec2(0.0, 1.0)});
  }
  const auto jacobian = Linearised(NormalErrors{intrinsics, along_axes, pose}).jacobian;
  const double sum = (jacobian * covariance).cwiseProduct(jacobian).sum();
  return std::sqrt(sum / static_cast<double>(points.size()));
}

bool IsInPicture(const CameraIntrinsics& intrinsics, const glm::dvec2& pixel) {
  return pixel.x >= -0.5 && pixel.x < intrinsics.width_px - 0.5 && pixel.y >= -0.5 &&
         pixel.y < intrinsics.height_px - 0.5;
}

std::vector<PointMatch> PointsOnEdges(const EdgeView& view,
                                      const PictureSlopes& slopes,
                                      const glm::dmat4& pose) {
  std::vector<PointMatch> points;
  for (const EdgePlace& place : view.PlacesOf(pose, slopes, kMostJudgedPlaces)) {
    points.push_back({place.point_m, place.pixel});
  }
  return points;
}

void StoreCovariance(const Covariance& covariance, PoseCorrection& result) {
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = 0; j < 6; ++j) {
      result.motion_covariance[i][j] =
          covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
    }
  }
}

}  // namespace

void PoseCorrectionOptions::Validate() const {
  const auto above_0 = [](double value) { return value > 0.0 && std::isfinite(value); };
  RequireOption(above_0(rotation_sigma_rad), "rotation_sigma_rad", rotation_sigma_rad, "above 0");
  RequireOption(above_0(position_sigma_m), "position_sigma_m", position_sigma_m, "above 0");
  RequireOption(least_shift_px >= 0.0 && std::isfinite(least_shift_px),
                "least_shift_px",
                least_shift_px,
                "0 or more");
  const double reach = reach_px.value_or(2.0);
  RequireOption(reach > 1.0 && std::isfinite(reach), "reach_px", reach, "above 1");
}

PoseCorrection CorrectPoseByEdges(const Lens& lens,
                                  std::span<const Rgb8Image> pictures,
                                  const EdgeModel& model,
                                  const glm::dmat4& stated,
                                  const PoseCorrectionOptions& options) {
  options.Validate();
  const CameraIntrinsics& intrinsics = lens.Intrinsics();
  if (pictures.empty()) throw std::invalid_argument("pictures: expected at least one");
  std::vector<PictureSlopes> coarse;
  std::vector<PictureSlopes> fine;
  for (const Rgb8Image& picture : pictures) {
    RequireLensSize(intrinsics, picture);
    coarse.emplace_back(picture, 2.0);
    fine.emplace_back(picture, 1.0);
  }
  const std::vector<MeshEdge> joined = JoinedEdges(model.edges);
  const EdgeView view(lens, {joined, model.rays});
  const double reach_px = options.reach_px.value_or(intrinsics.width_px / 60.0);
  std::vector<const PictureSlopes*> rough_pictures;
  std::vector<const PictureSlopes*> fine_pictures;
  for (const std::size_t i : PicturesWithEdges(view, fine, stated, reach_px)) {
    rough_pictures.push_back(&coarse[i]);
    fine_pictures.push_back(&fine[i]);
  }
  const JudgedPlaces judged =
      JudgedPlacesOf(view, joined, fine.front(), stated, fine_pictures.size());
  const PosePrior prior = PriorOf(stated, options);
  PoseCorrection result;
  result.camera_from_world = stated;
  StoreCovariance(prior.sigmas.cwiseAbs2().asDiagonal(), result);
  if (judged.places.size() < kFewestEdgePlaces) {
    result.reason = "hardly an edge of the mesh is in view";
    return result;
  }
  const PoseEvidence rough_evidence(view, rough_pictures, judged, prior, reach_px);
  const PoseEvidence evidence(view, fine_pictures, judged, prior, reach_px);
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
  for (const double mesh_sigma_m : kMeshSigmasM) {
    log_exact = std::max(log_exact, evidence.At(stated, last(mesh_sigma_m)).log_density);
    const glm::dmat4 pose = moved(usual, evidence, last(mesh_sigma_m));
    const Posterior at = evidence.At(pose, last(mesh_sigma_m));
    const double log_evidence =
        at.log_density - 0.5 * std::log(at.information.determinant() / prior_determinant);
    if (!(log_evidence > log_off)) continue;
    log_off = log_evidence;
    best = pose;
  }
  const EdgePictures seen{view,
                          joined,
                          judged.places,
                          fine_pictures,
                          evidence.StepsPerPx(),
                          GroundBelow(stated, model.rays, joined)};
  // The search takes edges to be off each by itself. Where it finds no pose that is more likely,
  // the stated one may still be off by less than it sees.
  const bool found_other = log_off + std::log(kOddsBeforehand) > log_exact;
  const EdgeAdjustment adjusted = AdjustPoseAndMesh(seen, prior, found_other ? best : stated);
  best = adjusted.camera_from_world;
  result.log_odds = adjusted.log_odds;
  result.mesh_sigma_m = adjusted.mesh_sigma_m;
  result.found_share = evidence.At(best, last(adjusted.mesh_sigma_m)).found_share;
  result.chance_share = evidence.ChanceShare(0.5 * reach_px);
  result.shift_px = ShiftPx(view, fine.front(), stated, best);
  // About the stated pose, where that one stays.
  const Motion off = MotionBetween(stated, best);
  const auto store = [&](const glm::dmat4& pose, const Covariance& covariance) {
    StoreCovariance(covariance, result);
    result.shift_sigma_px =
        SigmaPx(intrinsics, pose, covariance, PointsOnEdges(view, fine.front(), pose));
  };
  store(stated, adjusted.covariance + off * off.transpose());
  if (!(result.found_share >= result.chance_share + kLeastFoundOverChance)) {
    result.reason = NumberText("%.0f %%", 100.0 * result.found_share) +
                    " of the mesh's edges are found in the pictures, where chance finds " +
                    NumberText("%.0f %%", 100.0 * result.chance_share);
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
  if (!(evidence.SquaredSigmas(best) <= kMostSquaredSigmas)) {
    result.reason = "the edges in the pictures fit best farther from it than it can be off";
    return result;
  }
  result.corrected = true;
  result.camera_from_world = best;
  store(best, adjusted.covariance);
  return result;
}

std::optional<double> PlaceSigmaPx(const Lens& lens,
                                   const PoseCorrection& found,
                                   const glm::dvec3& point_world_m) {
  const glm::dmat4& pose = found.camera_from_world;
  const auto pixel = lens.ProjectToPixel(glm::dvec3(pose * glm::dvec4(point_world_m, 1.0)));
  if (!pixel || !IsInPicture(lens.Intrinsics(), *pixel)) return std::nullopt;
  Covariance covariance;
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = 0; j < 6; ++j) {
      covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          found.motion_covariance[i][j];
    }
  }
  const PointMatch point{point_world_m, *pixel};
  return SigmaPx(lens.Intrinsics(), pose, covariance, {&point, 1});
}

}  // namespace pleinair
