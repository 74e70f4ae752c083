#include "objects/light_in_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "objects/near_sunlight.h"
#include "objects/posed_objects.h"
#include "scene/ray_caster.h"
#include "scene/sphere_directions.h"

namespace pleinair {
namespace {

// Probes stand halfway between the middle of an object's box and its corners.
constexpr std::size_t kProbes = 8;
constexpr float kProbeAt = 0.5f;  // Share of half a side.
// Four a cell on average, 1 to 9; a cell without any, in some tilted poses, counts as dark.
constexpr int kProbeRays = 1024;
constexpr std::size_t kRaysPerRun = 64;  // Rays that one thread casts together.
static_assert(kProbeRays % kRaysPerRun == 0);
// Radiance at a place in the box is linear in it: its value in the middle, and what it gains along
// half a side.
constexpr std::size_t kTerms = 4;

glm::vec3 SideOf(std::size_t probe) {
  return {(probe & 1u) != 0 ? 1.0f : -1.0f,
          (probe & 2u) != 0 ? 1.0f : -1.0f,
          (probe & 4u) != 0 ? 1.0f : -1.0f};
}
glm::vec3 HalfSideOf(const BoundingBox& box) {
  constexpr float kLeastM = 1e-6f;  // Of a plane's box.
  return glm::max(0.5f * (box.upper_m - box.lower_m), kLeastM);
}
glm::vec3 MiddleOf(const BoundingBox& box) { return 0.5f * (box.lower_m + box.upper_m); }
// A correction counts in full while no corner of the object's box has moved farther than the box's
// diagonal, and not at all from three diagonals on. Light from one side of an object counts by how
// much that side still points the same way, as a mean over all axes, to a power: for a turning
// statue of 15000 faces 4 was better than 1 and 2.
constexpr double kFullReach = 1.0;
constexpr double kFarthestReach = 3.0;
constexpr double kTurnPower = 4.0;

// The turn in a transform that keeps angles.
glm::dmat3 RotationOf(const glm::dmat4& pose) {
  const glm::dmat3 linear(pose);
  return linear * (1.0 / std::cbrt(glm::determinant(linear)));
}

std::vector<glm::mat3> OwnFromWorld(std::span<const glm::dmat4> world_from_given) {
  std::vector<glm::mat3> own_from_world;
  for (const glm::dmat4& pose : world_from_given) {
    own_from_world.emplace_back(glm::transpose(RotationOf(pose)));
  }
  return own_from_world;
}

DirectionalLight UnitSun(std::size_t light) {
  DirectionalLight sun;
  if (light == 0) sun.irradiance_rgb = glm::dvec3(1.0);
  return sun;
}

}  // namespace

LightInMotion::LightInMotion(const PreparedScene& scene)
    : real_(&scene.patches),
      surfaces_reflect_(scene.options.bounces != 0),
      directions_(internal::SphereDirections(kProbeRays, 1)) {}

bool LightInMotion::KeepsShape(const glm::dmat4& world_from_given) {
  const glm::dmat3 linear(world_from_given);
  const double determinant = glm::determinant(linear);
  if (!(determinant > 0.0) || !std::isfinite(determinant)) return false;
  const glm::dmat3 rotation = RotationOf(world_from_given);
  const glm::dmat3 product = glm::transpose(rotation) * rotation;
  // Poses are read from files in decimals.
  constexpr double kMostOff = 1e-4;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      if (!(std::abs(product[i][j] - (i == j ? 1.0 : 0.0)) < kMostOff)) return false;
    }
  }
  return true;
}

void LightInMotion::Start(const PlacedObjects& stood,
                          const ObjectGather& gather,
                          const VerticesByLight& irradiance,
                          const LightSubset& of) {
  const FrameBasis& basis = of.basis;
  const std::span<const std::size_t> lights = of.lights;
  const PatchScene& objects = stood.objects.Objects();
  if (shape_.VertexCount() != gather.VertexCount()) {
    shape_ = OwnShape(gather, objects, OwnFromWorld(stood.world_from_given));
  } else {
    std::vector<std::size_t> all(gather.PartCount());
    std::iota(all.begin(), all.end(), std::size_t{0});
    shape_.Refine(gather, all, objects, OwnFromWorld(stood.world_from_given));
  }
  buried_ = gather.BuriedVertices();
  const std::size_t count = lights.size();
  const std::vector<glm::vec3> outside = OutsideOf(stood, of);
  // The irradiance includes reflected light, which must be known to be subtracted.
  const std::vector<glm::vec3> first =
      shape_.FromFaces(FaceRadiosity(stood.objects, outside, lights), count);
  std::vector<glm::vec3> received(outside.size());
  outside_correction_.assign(basis.LightCount(), {});
  correction_.assign(basis.LightCount(), {});
  for (std::size_t i = 0; i < count; ++i) {
    const std::vector<glm::vec3>* const was =
        lights[i] < irradiance.size() && !irradiance[lights[i]].empty() ? &irradiance[lights[i]]
                                                                        : nullptr;
    std::vector<glm::vec3>& correction = outside_correction_[lights[i]];
    correction.assign(shape_.VertexCount(), glm::vec3(0.0f));
    for (std::size_t v = 0; v < correction.size(); ++v) {
      const std::size_t at = v * count + i;
      if (was != nullptr) correction[v] = (*was)[v] - first[at] - outside[at];
      received[at] = outside[at] + correction[v];
    }
  }
  const std::vector<glm::vec3> reflected =
      shape_.FromFaces(FaceRadiosity(stood.objects, received, lights), count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::vector<glm::vec3>& of_outside = outside_correction_[lights[i]];
    std::vector<glm::vec3>& correction = correction_[lights[i]];
    correction.assign(shape_.VertexCount(), glm::vec3(0.0f));
    for (std::size_t v = 0; v < correction.size(); ++v) {
      // The complete irradiance, less the base's.
      correction[v] = of_outside[v] + first[v * count + i] - reflected[v * count + i];
    }
  }
  corrected_at_.assign(gather.PartCount(),
                       std::make_shared<const std::vector<glm::dmat4>>(
                           stood.world_from_given.begin(), stood.world_from_given.end()));
}

void LightInMotion::Update(const PlacedObjects& placed,
                           const ObjectGather& gather,
                           std::span<const Gathered> gathered,
                           const LightSubset& of,
                           VerticesByLight& irradiance) {
  const FrameBasis& basis = of.basis;
  const std::span<const std::size_t> lights = of.lights;
  const std::size_t count = lights.size();
  const std::size_t vertices = shape_.VertexCount();
  outside_correction_.resize(basis.LightCount());
  correction_.resize(basis.LightCount());
  irradiance.resize(basis.LightCount());
  for (const std::size_t light : lights) {
    outside_correction_[light].resize(vertices, glm::vec3(0.0f));
    correction_[light].resize(vertices, glm::vec3(0.0f));
    irradiance[light].resize(vertices);
  }
  const auto here = std::make_shared<const std::vector<glm::dmat4>>(placed.world_from_given.begin(),
                                                                    placed.world_from_given.end());
  std::vector<std::size_t> parts;
  parts.reserve(gathered.size());
  for (const Gathered& part : gathered) parts.push_back(part.part);
  shape_.Refine(gather, parts, placed.objects.Objects(), OwnFromWorld(placed.world_from_given));
  const std::vector<glm::vec3> outside = OutsideOf(placed, of);
  for (const Gathered& part : gathered) {
    const auto [begin, end] = gather.VerticesOf(part.part);
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t v = begin; v < end; ++v) {
        outside_correction_[lights[i]][v] = part.irradiance[i][v - begin] - outside[v * count + i];
      }
    }
    corrected_at_[part.part] = here;
  }
  const std::vector<float> weights = WeightsOf(placed);
  const std::size_t objects = placed.world_from_given.size();
  const auto weight_of = [&](std::size_t v) {
    return weights[v / ObjectGather::kVerticesPerPart * objects + shape_.ObjectOf(v)];
  };
  std::vector<glm::vec3> received(outside.size());
  tbb::parallel_for(std::size_t{0}, vertices, [&](std::size_t v) {
    const float weight = weight_of(v);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t at = v * count + i;
      received[at] = glm::max(outside[at] + weight * outside_correction_[lights[i]][v], 0.0f);
    }
  });
  const std::vector<glm::vec3> face_radiosity = FaceRadiosity(placed.objects, received, lights);
  const std::vector<glm::vec3> reflected = shape_.FromFaces(face_radiosity, count);
  std::vector<glm::vec3> of_light(placed.objects.Objects().FaceCount() + real_->FaceCount());
  for (std::size_t i = 0; i < count && !gathered.empty(); ++i) {
    for (std::size_t face = 0; face < placed.objects.Objects().FaceCount(); ++face) {
      of_light[face] = face_radiosity[face * count + i];
    }
    tbb::parallel_for(std::size_t{0}, gathered.size(), [&](std::size_t p) {
      const std::vector<glm::vec3> reflected_here =
          gather.IrradianceOf(gathered[p].part, nullptr, of_light);
      const auto [begin, end] = gather.VerticesOf(gathered[p].part);
      for (std::size_t v = begin; v < end; ++v) {
        correction_[lights[i]][v] = outside_correction_[lights[i]][v] + reflected_here[v - begin] -
                                    reflected[v * count + i];
      }
    });
  }
  tbb::parallel_for(std::size_t{0}, vertices, [&](std::size_t v) {
    const float weight = weight_of(v);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t at = v * count + i;
      irradiance[lights[i]][v] =
          glm::max(outside[at] + reflected[at] + weight * correction_[lights[i]][v], 0.0f);
    }
  });
  for (const std::size_t light : lights) ObjectGather::Fill(buried_, irradiance[light]);
}

std::vector<glm::vec3> LightInMotion::OutsideOf(const PlacedObjects& placed,
                                                const LightSubset& of) {
  const FrameBasis& basis = of.basis;
  const std::span<const std::size_t> lights = of.lights;
  const std::size_t count = lights.size();
  const Mesh& mesh = placed.objects.Objects().mesh;
  const auto bounds = BoundsOfObjects(mesh);
  const std::vector<glm::mat3> own_from_world = OwnFromWorld(placed.world_from_given);
  seen_.resize(bounds.size());
  // [((object * cells + cell) * lights + light) * terms + term].
  std::vector<glm::vec3> cells(bounds.size() * OwnShape::kCells * count * kTerms, glm::vec3(0.0f));
  for (std::size_t object = 0; object < bounds.size(); ++object) {
    if (!bounds[object]) continue;
    Seen& seen = seen_[object];
    if (seen.world_from_given != placed.world_from_given[object]) {
      seen = SeenFrom(*bounds[object], placed.world_from_given[object]);
    }
    std::vector<std::size_t> cell_of(directions_.size());
    std::array<float, OwnShape::kCells> rays{};
    for (std::size_t k = 0; k < directions_.size(); ++k) {
      cell_of[k] = OwnShape::CellOf(own_from_world[object] * directions_[k]);
      rays[cell_of[k]] += static_cast<float>(kProbes);
    }
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
      const std::vector<glm::vec3> radiance =
          Radiance(seen, placed.objects.Objects(), basis, lights[i]);
      for (std::size_t ray = 0; ray < radiance.size(); ++ray) {
        const std::size_t cell = cell_of[ray % directions_.size()];
        const glm::vec3 share = std::numbers::pi_v<float> / rays[cell] * radiance[ray];
        const glm::vec3 side = SideOf(ray / directions_.size()) / kProbeAt;
        glm::vec3* const terms =
            cells.data() + ((object * OwnShape::kCells + cell) * count + i) * kTerms;
        terms[0] += share;
        for (int axis = 0; axis < 3; ++axis) terms[1 + axis] += side[axis] * share;
      }
    });
  }
  const std::vector<glm::vec3> terms = shape_.FromCells(cells, count * kTerms);
  std::vector<glm::vec3> outside(shape_.VertexCount() * count);
  tbb::parallel_for(std::size_t{0}, shape_.VertexCount(), [&](std::size_t v) {
    const auto& of_object = bounds[shape_.ObjectOf(v)];
    if (!of_object) return;
    const glm::vec3 at =
        (mesh.positions_m[v] - MiddleOf(of_object->box)) / HalfSideOf(of_object->box);
    for (std::size_t i = 0; i < count; ++i) {
      const glm::vec3* const term = terms.data() + (v * count + i) * kTerms;
      outside[v * count + i] =
          glm::max(term[0] + at.x * term[1] + at.y * term[2] + at.z * term[3], 0.0f);
    }
  });
  return outside;
}

LightInMotion::Seen LightInMotion::SeenFrom(const ObjectBounds& object,
                                            const glm::dmat4& world_from_given) const {
  const std::size_t rays = kProbes * directions_.size();
  Seen seen{world_from_given, std::vector<std::int32_t>(rays, PatchScene::kSky), {}};
  const auto reach_m = static_cast<float>(1.0 + NearSunlightOptions().reach) * object.radius_m;
  std::vector<std::optional<glm::vec3>> near(rays);
  const std::size_t runs = directions_.size() / kRaysPerRun;
  tbb::parallel_for(std::size_t{0}, kProbes * runs, [&](std::size_t run) {
    const glm::vec3 place_m =
        MiddleOf(object.box) + kProbeAt * SideOf(run / runs) * HalfSideOf(object.box);
    const glm::vec3* const directions = directions_.data() + run % runs * kRaysPerRun;
    std::array<FaceHit, kRaysPerRun> hits;
    real_->caster.IntersectFrom(
        place_m, RayCaster::Origin::kMayBeOnMesh, directions, kRaysPerRun, hits.data());
    for (std::size_t k = 0; k < kRaysPerRun; ++k) {
      if (hits[k].triangle == FaceHit::kNone) continue;
      const std::size_t ray = run * kRaysPerRun + k;
      seen.sources[ray] = real_->FaceOfHit(hits[k]);
      if (hits[k].distance_m > reach_m) continue;
      // The exact place on it.
      const auto hit = real_->caster.Intersect(place_m, directions[k]);
      if (!hit) continue;
      const std::int32_t side = PatchScene::SideOfHit(*hit, directions[k]);
      near[ray] =
          OffsetFromSurface(hit->position_m, real_->SideNormal(static_cast<std::size_t>(side)));
    }
  });
  for (std::size_t ray = 0; ray < rays; ++ray) {
    if (near[ray]) seen.near.push_back({ray, *near[ray]});
  }
  return seen;
}

std::vector<glm::vec3> LightInMotion::Radiance(const Seen& seen,
                                               const PatchScene& objects,
                                               const FrameBasis& basis,
                                               std::size_t light) const {
  std::vector<glm::vec3> radiance(seen.sources.size(), glm::vec3(0.0f));
  const std::vector<glm::vec3>& radiosity = basis.FaceRadiosity(light);
  const SkyShape* const sky = basis.Sky(light);
  std::vector<glm::vec3> of_sky(directions_.size(), glm::vec3(0.0f));
  for (std::size_t k = 0; sky != nullptr && k < directions_.size(); ++k) {
    if (directions_[k].z > 0.0f) of_sky[k] = sky->Radiance(directions_[k]);
  }
  for (std::size_t ray = 0; ray < radiance.size(); ++ray) {
    const std::int32_t source = seen.sources[ray];
    radiance[ray] = source == PatchScene::kSky ? of_sky[ray % directions_.size()]
                                               : std::numbers::inv_pi_v<float> *
                                                     radiosity[static_cast<std::size_t>(source)];
  }
  if (light != 0 || !surfaces_reflect_) return radiance;
  const std::vector<glm::vec3>& direct = basis.DirectIrradiance();
  const glm::vec3 to_sun(basis.BounceSun().direction_enu);
  tbb::parallel_for(std::size_t{0}, seen.near.size(), [&](std::size_t i) {
    const auto& [ray, start_m] = seen.near[i];
    const auto face = static_cast<std::size_t>(seen.sources[ray]);
    const float cosine = glm::dot(real_->FaceNormal(face), to_sun);
    const bool is_lit = cosine > 0.0f && to_sun.z > 0.0f &&
                        !objects.caster.Occluded(start_m, to_sun) &&
                        !real_->caster.Occluded(start_m, to_sun);
    radiance[ray] += std::numbers::inv_pi_v<float> * real_->face_albedo_rgb[face] *
                     (glm::vec3(is_lit ? cosine : 0.0f) - direct[face]);
  });
  return radiance;
}

std::vector<glm::vec3> LightInMotion::FaceRadiosity(const ObjectInterreflection& objects,
                                                    std::span<const glm::vec3> outside,
                                                    std::span<const std::size_t> lights) const {
  const std::size_t count = lights.size();
  std::vector<glm::vec3> interleaved(objects.Objects().FaceCount() * count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    std::vector<glm::vec3> of_light(shape_.VertexCount());
    for (std::size_t v = 0; v < of_light.size(); ++v) of_light[v] = outside[v * count + i];
    ObjectGather::Fill(buried_, of_light);
    const std::vector<glm::vec3> radiosity =
        objects.FaceRadiosity(UnitSun(lights[i]), std::span(&of_light, 1));
    for (std::size_t face = 0; face < radiosity.size(); ++face) {
      interleaved[face * count + i] = radiosity[face];
    }
  });
  return interleaved;
}

std::vector<float> LightInMotion::WeightsOf(const PlacedObjects& placed) const {
  const auto bounds = BoundsOfObjects(placed.objects.Objects().mesh);
  std::vector<float> weights;
  weights.reserve(corrected_at_.size() * bounds.size());
  for (const Poses& corrected_at : corrected_at_) {
    for (std::size_t object = 0; object < bounds.size(); ++object) {
      const glm::dmat4& now = placed.world_from_given[object];
      const glm::dmat4& then = (*corrected_at)[object];
      weights.push_back(1.0f);
      if (now == then || !bounds[object]) continue;
      const double boxes = BoxesMoved(then, now, bounds[object]->box);
      const glm::dmat3 turn = RotationOf(then * glm::inverse(now));
      const double still_points_there = (turn[0][0] + turn[1][1] + turn[2][2]) / 3.0;
      weights.back() = static_cast<float>(
          std::clamp((kFarthestReach - boxes) / (kFarthestReach - kFullReach), 0.0, 1.0) *
          std::pow(std::clamp(still_points_there, 0.0, 1.0), kTurnPower));
    }
  }
  return weights;
}

}  // namespace pleinair
