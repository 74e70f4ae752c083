#include "calib/internal/edge_adjustment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include <ceres/rotation.h>
#include <Eigen/Dense>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace pleinair {
namespace {

using Square = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

// Of one place in all of the pictures together, whatever the mesh: blur, texture, and the threshold
// between two surfaces.
constexpr double kPlaceNoisePx = 0.5;
// Share of places whose step of light is not the mesh's edge.
constexpr double kOtherStepShare = 0.3;
// How far a mesh's corners may be off, standard deviations along each axis: from a mesh that is
// exact to one that is guessed.
constexpr std::array kCornerSigmasM{0.003, 0.01, 0.02, 0.04, 0.08};
constexpr std::size_t kUsualCornerSigma = 3;
// How far each end of an edge may be elsewhere beyond that: the threshold between two surfaces,
// details that the mesh lacks, and another thing's edge. The probabilities are assumptions.
struct EdgeLevel {
  double sigma_px;
  double probability;
};
constexpr EdgeLevel kEdgeLevels[] = {{0.15, 0.6}, {0.5, 0.2}, {1.5, 0.12}, {4.0, 0.08}};
// Deviations of the stated pose that is off, as shares of the expected ones.
constexpr double kPriorShares[] = {0.25, 1.0};
// The search for steps is wider at first, while the pose is not known.
constexpr double kLoosened[] = {2.5, 2.5, 1.7, 1.0, 1.0, 1.0};

double Squared(double value) { return value * value; }

// What the pictures show of the places, from where one pose puts them, and the derivatives there.
struct Observed {
  explicit Observed(Eigen::Index places)
      : offset_px(Vector::Zero(places)),
        weight(Vector::Zero(places)),
        by_motion(Eigen::MatrixXd::Zero(places, 6)),
        by_point(Eigen::MatrixXd::Zero(places, 3)) {}

  Vector offset_px;  // Along the normal, to the steps of light.
  Vector weight;     // In [0, 1]: share of the pictures that show the edge.
  Eigen::MatrixXd by_motion;
  Eigen::MatrixXd by_point;  // Pixels along the normal, for a metre.
  // Of each edge: deviation of the steps that may be it, beyond the places' noise.
  std::vector<double> ambiguity_px;
};

// The steps of light in all of the pictures that may be one place of an edge.
struct Association {
  double weight = 0.0;  // Sum over the pictures.
  double sum_px = 0.0;
  double squares_px2 = 0.0;
};

// Deviations of pose and mesh, which edges are elsewhere, and what follows from them.
struct Explanation {
  double log_evidence = -std::numeric_limits<double>::infinity();
  bool is_exact = false;
  std::size_t corner_sigma = kUsualCornerSigma;  // Index of kCornerSigmasM.
  Motion motion = Motion::Zero();                // From the stated pose.
  Matrix6 covariance = Matrix6::Zero();
};

class Adjustment {
 public:
  Adjustment(const EdgePictures& seen, const PosePrior& prior)
      : seen_(seen), prior_(prior), count_(static_cast<Eigen::Index>(seen.places.size())) {
    std::map<std::array<double, 3>, std::size_t> corners;
    const auto corner = [&](const glm::dvec3& at) {
      return corners.try_emplace({at.x, at.y, at.z}, corners.size()).first->second;
    };
    std::map<std::size_t, std::size_t> numbers;
    for (const FixedPlace& place : seen.places) {
      const MeshEdge& edge = seen.edges[place.edge];
      const double part =
          glm::distance(edge.from_m, place.point_m) / glm::distance(edge.from_m, edge.to_m);
      const std::size_t number = numbers.try_emplace(place.edge, numbers.size()).first->second;
      places_.push_back({number,
                         {corner(edge.from_m), corner(edge.to_m)},
                         {1.0 - part, part},
                         {IsOnGround(edge.from_m), IsOnGround(edge.to_m)}});
    }
    for (std::size_t edge = 0; edge < numbers.size(); ++edge) ends_.push_back(EndsOf(edge));
  }

  EdgeAdjustment From(glm::dmat4 pose) const {
    std::size_t corner_sigma = kUsualCornerSigma;
    for (const double loosened : kLoosened) {
      const Observed observed = At(pose, kCornerSigmasM[corner_sigma], loosened);
      const Model model = ModelOf(observed, pose);
      Explanation best;
      // The next ones suffice: the most likely one is approached from stage to stage.
      const std::size_t first = corner_sigma - std::min<std::size_t>(corner_sigma, 1);
      const std::size_t last = std::min(corner_sigma + 1, kCornerSigmasM.size() - 1);
      for (std::size_t sigma = first; sigma <= last; ++sigma) {
        const Explanation here = Explain(model, sigma, 1.0);
        if (here.log_evidence > best.log_evidence) best = here;
      }
      corner_sigma = best.corner_sigma;
      pose = MovedPose(prior_.pose, best.motion);
    }
    return Mean(ModelOf(At(pose, kCornerSigmasM[corner_sigma], 1.0), pose));
  }

 private:
  struct Place {
    std::size_t edge;  // Numbered from 0, without edges that have no place.
    std::array<std::size_t, 2> corner;
    std::array<double, 2> share;  // Of each corner's displacement.
    std::array<bool, 2> on_ground;
  };

  // The observations whitened by the places' noise: R the root of weight over noise, rows of places
  // without weight are 0.
  struct Model {
    Vector seen;                // R times the offset from where the stated pose puts a place.
    Eigen::MatrixXd by_motion;  // R times the derivative.
    Square mesh;                // R C R, of corners that are displaced by 1 m.
    std::vector<Eigen::MatrixX2d> ends;  // R times each edge's places by its two ends.
    std::vector<double> ambiguity_px;
  };

  bool IsOnGround(const glm::dvec3& corner_m) const {
    constexpr double kOnGroundM = 0.02;
    return seen_.ground_m && std::abs(corner_m.z - *seen_.ground_m) < kOnGroundM;
  }

  // An edge's places by its two visible ends.
  Eigen::MatrixX2d EndsOf(std::size_t edge) const {
    Eigen::MatrixX2d ends = Eigen::MatrixX2d::Zero(count_, 2);
    double low = 1.0;
    double high = 0.0;
    for (const Place& place : places_) {
      if (place.edge != edge) continue;
      low = std::min(low, place.share[1]);
      high = std::max(high, place.share[1]);
    }
    for (Eigen::Index i = 0; i < count_; ++i) {
      const Place& place = places_[static_cast<std::size_t>(i)];
      if (place.edge != edge) continue;
      const double at = high > low ? (place.share[1] - low) / (high - low) : 0.5;
      ends.row(i) << 1.0 - at, at;
    }
    return ends;
  }

  // Offsets along a place's normal of the mesh's other edges that are parallel to it and near.
  static std::vector<double> RivalsPx(const std::vector<std::optional<EdgePlace>>& shown,
                                      const EdgePlace& here) {
    constexpr double kParallel = 0.9;
    constexpr double kBesidePx = 1.5 * kEdgePlaceStepPx;
    constexpr double kFarPx = 12.0;
    const glm::dvec2 along(-here.normal.y, here.normal.x);
    struct Rival {
      double beside_px;
      double offset_px;
    };
    std::map<std::size_t, Rival> nearest;  // The place of each edge that is the least beside.
    for (const std::optional<EdgePlace>& other : shown) {
      if (!other || other->edge == here.edge) continue;
      const double cosine = glm::dot(other->normal, here.normal);
      if (std::abs(cosine) < kParallel) continue;
      const glm::dvec2 between = other->pixel - here.pixel;
      const Rival rival{std::abs(glm::dot(between, along)),
                        glm::dot(between, other->normal) / cosine};
      if (rival.beside_px > kBesidePx || std::abs(rival.offset_px) > kFarPx) continue;
      const auto [known, is_new] = nearest.try_emplace(other->edge, rival);
      if (!is_new && rival.beside_px < known->second.beside_px) known->second = rival;
    }
    std::vector<double> rivals;
    rivals.reserve(nearest.size());
    for (const auto& [edge, rival] : nearest) rivals.push_back(rival.offset_px);
    return rivals;
  }

  Association Associate(const EdgePlace& here,
                        const std::vector<double>& rivals_px,
                        double sigma_px) const {
    const auto likelihood = [&](double off_px) {
      return std::exp(-0.5 * Squared(off_px / sigma_px));
    };
    // Of a step that is no edge of the mesh, over that of one in the edge's place.
    const double other = kOtherStepShare / (1.0 - kOtherStepShare) * seen_.steps_per_px * sigma_px *
                         std::sqrt(2.0 * std::numbers::pi);
    Association all;
    for (const PictureSlopes* slopes : seen_.pictures) {
      double total = other;
      Association here_only;
      for (const double step : StepsAlong(*slopes, here, 4.0 * sigma_px + 1.0)) {
        double of_any = likelihood(step);
        for (const double rival : rivals_px) of_any += likelihood(step - rival);
        // Its own share of what the mesh's edges explain.
        const double mine = Squared(likelihood(step)) / of_any;
        total += mine;
        here_only.weight += mine;
        here_only.sum_px += mine * step;
        here_only.squares_px2 += mine * step * step;
      }
      all.weight += here_only.weight / total;
      all.sum_px += here_only.sum_px / total;
      all.squares_px2 += here_only.squares_px2 / total;
    }
    return all;
  }

  Observed At(const glm::dmat4& pose, double corner_sigma_m, double loosened) const {
    Observed observed(count_);
    std::vector<std::optional<EdgePlace>> shown;
    for (const FixedPlace& place : seen_.places) {
      shown.push_back(PlaceAt(seen_.view, *seen_.pictures.front(), place, pose));
    }
    std::vector<EdgeMatch> matches;
    std::vector<Eigen::Index> rows;
    std::vector<double> weights(ends_.size(), 0.0);
    std::vector<double> spreads(ends_.size(), 0.0);
    for (Eigen::Index i = 0; i < count_; ++i) {
      const std::optional<EdgePlace>& here = shown[static_cast<std::size_t>(i)];
      if (!here) continue;
      // Wider ones would match whatever is there.
      constexpr double kWidestPx = 4.0;
      const double depth_m = std::max(1e-3, (pose * glm::dvec4(here->point_m, 1.0)).z);
      const double mesh_px = corner_sigma_m * seen_.view.Intrinsics().fx_px / depth_m;
      const double sigma_px = std::min(kWidestPx, loosened * std::hypot(kPlaceNoisePx, mesh_px));
      const Association found = Associate(*here, RivalsPx(shown, *here), sigma_px);
      constexpr double kLeastWeight = 0.01;
      if (!(found.weight > kLeastWeight)) continue;
      observed.offset_px[i] = found.sum_px / found.weight;
      observed.weight[i] = found.weight / static_cast<double>(seen_.pictures.size());
      observed.by_point.row(i) = ByPoint(*here, pose);
      const std::size_t edge = places_[static_cast<std::size_t>(i)].edge;
      weights[edge] += observed.weight[i];
      spreads[edge] +=
          observed.weight[i] * (found.squares_px2 / found.weight - Squared(observed.offset_px[i]));
      matches.push_back({here->edge, {here->point_m, here->pixel}, here->normal});
      rows.push_back(i);
    }
    for (std::size_t edge = 0; edge < ends_.size(); ++edge) {
      const double spread = weights[edge] > 0.0 ? spreads[edge] / weights[edge] : 0.0;
      observed.ambiguity_px.push_back(std::sqrt(std::max(0.0, spread - Squared(kPlaceNoisePx))));
    }
    if (matches.empty()) return observed;
    const auto jacobian = Linearised(NormalErrors{seen_.view.Intrinsics(), matches, pose}).jacobian;
    for (std::size_t k = 0; k < rows.size(); ++k) {
      observed.by_motion.row(rows[k]) = jacobian.row(static_cast<Eigen::Index>(k));
    }
    return observed;
  }

  Eigen::RowVector3d ByPoint(const EdgePlace& here, const glm::dmat4& pose) const {
    constexpr double kStepM = 0.01;
    Eigen::RowVector3d by_point = Eigen::RowVector3d::Zero();
    for (int axis = 0; axis < 3; ++axis) {
      glm::dvec3 beside = here.point_m;
      beside[axis] += kStepM;
      const auto there = seen_.view.Project(pose, beside);
      if (there) by_point[axis] = glm::dot(*there - here.pixel, here.normal) / kStepM;
    }
    return by_point;
  }

  // Of the places' displacements, for corners that are displaced by 1 m along each axis.
  Square MeshCovariance(const Eigen::MatrixXd& by_point) const {
    Square covariance = Square::Zero(count_, count_);
    for (Eigen::Index i = 0; i < count_; ++i) {
      for (Eigen::Index j = 0; j <= i; ++j) {
        const Place& a = places_[static_cast<std::size_t>(i)];
        const Place& b = places_[static_cast<std::size_t>(j)];
        double along_ground = 0.0;
        double upward = 0.0;
        for (std::size_t m = 0; m < 2; ++m) {
          for (std::size_t n = 0; n < 2; ++n) {
            if (a.corner[m] != b.corner[n]) continue;
            along_ground += a.share[m] * b.share[n];
            if (!a.on_ground[m]) upward += a.share[m] * b.share[n];
          }
        }
        covariance(i, j) = covariance(j, i) =
            along_ground * by_point.row(i).head<2>().dot(by_point.row(j).head<2>()) +
            upward * by_point(i, 2) * by_point(j, 2);
      }
    }
    return covariance;
  }

  Model ModelOf(const Observed& observed, const glm::dmat4& pose) const {
    const Vector root = observed.weight.cwiseSqrt() / kPlaceNoisePx;
    const Vector from_stated =
        observed.offset_px + observed.by_motion * MotionBetween(prior_.pose, pose);
    Model model{root.cwiseProduct(from_stated),
                root.asDiagonal() * observed.by_motion,
                root.asDiagonal() * MeshCovariance(observed.by_point) * root.asDiagonal(),
                {},
                observed.ambiguity_px};
    for (const Eigen::MatrixX2d& ends : ends_) model.ends.emplace_back(root.asDiagonal() * ends);
    return model;
  }

  // The most likely levels of the edges, by ascent edge by edge, and the pose that follows. Of the
  // whitened observations the covariance is A = I + R (mesh + edges + pose) R; an edge's level
  // changes it by two columns.
  Explanation Explain(const Model& model, std::size_t corner_sigma, double share) const {
    const Motion variances = (share * prior_.sigmas).cwiseAbs2();
    std::vector<std::size_t> level(ends_.size(), 0);
    const auto variance_px2 = [&](std::size_t edge, std::size_t of) {
      return Squared(kEdgeLevels[of].sigma_px) + Squared(model.ambiguity_px[edge]);
    };
    Square covariance = Squared(kCornerSigmasM[corner_sigma]) * model.mesh;
    covariance.noalias() += model.by_motion * variances.asDiagonal() * model.by_motion.transpose();
    for (std::size_t edge = 0; edge < ends_.size(); ++edge) {
      covariance.noalias() +=
          variance_px2(edge, 0) * model.ends[edge] * model.ends[edge].transpose();
    }
    covariance.diagonal().array() += 1.0;
    const Eigen::LLT<Square> factor(covariance);
    Square inverse = factor.solve(Square::Identity(count_, count_));
    Explanation found;
    found.is_exact = share == 0.0;
    found.corner_sigma = corner_sigma;
    found.log_evidence = -factor.matrixLLT().diagonal().array().log().sum() -
                         0.5 * model.seen.dot(inverse * model.seen) +
                         static_cast<double>(ends_.size()) * std::log(kEdgeLevels[0].probability);
    constexpr int kSweeps = 3;
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      bool changed = false;
      for (std::size_t edge = 0; edge < ends_.size(); ++edge) {
        const Eigen::MatrixX2d solved = inverse * model.ends[edge];
        const Eigen::Matrix2d information = model.ends[edge].transpose() * solved;
        const Eigen::Vector2d pull = solved.transpose() * model.seen;
        constexpr double kLeastGain = 1e-9;  // So that rounding does not go back and forth.
        double most = kLeastGain;
        std::size_t to_level = level[edge];
        Eigen::Matrix2d update = Eigen::Matrix2d::Zero();
        for (std::size_t to = 0; to < std::size(kEdgeLevels); ++to) {
          // By the matrix determinant lemma and Woodbury's identity.
          const double more = variance_px2(edge, to) - variance_px2(edge, level[edge]);
          const Eigen::Matrix2d ratio = Eigen::Matrix2d::Identity() + more * information;
          const Eigen::Matrix2d change = more * ratio.inverse();
          const double gain =
              -0.5 * std::log(ratio.determinant()) + 0.5 * pull.dot(change * pull) +
              std::log(kEdgeLevels[to].probability / kEdgeLevels[level[edge]].probability);
          if (!(gain > most)) continue;
          most = gain;
          to_level = to;
          update = change;
        }
        if (to_level == level[edge]) continue;
        changed = true;
        level[edge] = to_level;
        found.log_evidence += most;
        inverse.noalias() -= solved * update * solved.transpose();
      }
      if (!changed) break;
    }
    const Eigen::MatrixXd pulled = inverse * model.by_motion;
    found.motion = variances.cwiseProduct(pulled.transpose() * model.seen);
    found.covariance = variances.asDiagonal();
    found.covariance -=
        variances.asDiagonal() * (pulled.transpose() * model.by_motion) * variances.asDiagonal();
    return found;
  }

  EdgeAdjustment Mean(const Model& model) const {
    constexpr double kOff = kOddsBeforehand / (1.0 + kOddsBeforehand);
    std::vector<Explanation> all;
    Explanation best;
    for (std::size_t sigma = 0; sigma < kCornerSigmasM.size(); ++sigma) {
      all.push_back(Explain(model, sigma, 0.0));
      all.back().log_evidence += std::log(1.0 - kOff);
      for (const double share : kPriorShares) {
        all.push_back(Explain(model, sigma, share));
        all.back().log_evidence += std::log(kOff / std::size(kPriorShares));
      }
    }
    for (const Explanation& one : all) {
      if (one.log_evidence > best.log_evidence) best = one;
    }
    // So that the odds stay finite where all of one side underflow.
    double off = std::numeric_limits<double>::min();
    double exact = off;
    Motion mean = Motion::Zero();
    Matrix6 squares = Matrix6::Zero();
    for (const Explanation& one : all) {
      const double likely = std::exp(one.log_evidence - best.log_evidence);
      (one.is_exact ? exact : off) += likely;
      mean += likely * one.motion;
      squares += likely * (one.covariance + one.motion * one.motion.transpose());
    }
    mean /= off + exact;
    EdgeAdjustment result;
    result.camera_from_world = MovedPose(prior_.pose, mean);
    result.covariance = squares / (off + exact) - mean * mean.transpose();
    result.mesh_sigma_m = kCornerSigmasM[best.corner_sigma];
    result.log_odds = std::log(off / exact);
    return result;
  }

  const EdgePictures& seen_;
  const PosePrior& prior_;
  Eigen::Index count_;
  std::vector<Place> places_;
  std::vector<Eigen::MatrixX2d> ends_;  // Of each edge.
};

}  // namespace

std::optional<EdgePlace> PlaceAt(const EdgeView& view,
                                 const PictureSlopes& picture,
                                 const FixedPlace& place,
                                 const glm::dmat4& pose) {
  constexpr double kAlongM = 0.01;
  constexpr double kMarginPx = 4.0;
  const auto here = view.Project(pose, place.point_m);
  const auto beside = view.Project(pose, place.point_m + kAlongM * place.along_m);
  if (!here || !beside || !picture.Holds(*here, kMarginPx)) return std::nullopt;
  const glm::dvec2 along = *beside - *here;
  const double length = glm::length(along);
  if (!(length > 0.0)) return std::nullopt;
  return EdgePlace{place.edge, place.point_m, *here, glm::dvec2(-along.y, along.x) / length, {}};
}

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

EdgeAdjustment AdjustPoseAndMesh(const EdgePictures& seen,
                                 const PosePrior& prior,
                                 const glm::dmat4& start) {
  return Adjustment(seen, prior).From(start);
}

}  // namespace pleinair
