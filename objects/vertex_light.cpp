#include "objects/vertex_light.h"

#include <algorithm>
#include <utility>

#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "relight/volume/environment.h"
#include "scene/stopwatch.h"

namespace pleinair {
namespace {

// First guesses on two cores, for some 4000 vertices: see bench/run_bench.cpp.
constexpr double kSetUpGuessMs = 110.0;
constexpr double kNearGuessMs = 40.0;
constexpr double kLightGuessMs = 10.0;
constexpr double kSingleProbeGuessMs = 3.0;
constexpr double kWithoutObjectsGuessMs = 1.5;
constexpr double kBetweenGuessMs = 50.0;
constexpr double kFollowGuessMs = 20.0;
constexpr double kDaylightGuessMs = 40.0;
constexpr double kSumGuessMs = 0.2;

}  // namespace

VertexLight::VertexLight(const PreparedScene& scene,
                         const Mesh& room,
                         const ObjectLightOptions& options)
    : scene_(scene),
      room_(room),
      options_(options),
      interreflection_({}),
      motion_(scene),
      single_probe_(scene.patches, options.single_probe),
      set_up_cost_(kSetUpGuessMs),
      near_cost_(kNearGuessMs),
      light_costs_{LearnedCost(kLightGuessMs),
                   LearnedCost(kSingleProbeGuessMs),
                   LearnedCost(kWithoutObjectsGuessMs)},
      between_cost_(kBetweenGuessMs),
      follow_cost_(kFollowGuessMs),
      daylight_cost_(kDaylightGuessMs),
      sum_cost_(kSumGuessMs) {}

void VertexLight::Pose(const PosedObjects& posed) {
  const std::vector<VirtualObject>& objects = posed.Objects();
  objects_ = &objects;
  follows_ = Leave({posed.Poses().begin(), posed.Poses().end()});
  if (left_ && !left_->interreflection) left_->interreflection = std::move(interreflection_);
  interreflection_ = ObjectInterreflection(objects);
  daylight_.reset();
  if (options_.daylight == Daylight::kSamples && !objects.empty()) {
    daylight_ = std::make_unique<DirectDaylight>(
        room_, scene_.patches.caster, interreflection_.Objects(), options_.direct_daylight);
  }
  sampled_shapes_.clear();
  irradiance_.clear();
  std::vector<BoundingBox> boxes;
  for (const VirtualObject& object : objects) {
    irradiance_.emplace_back(object.mesh.positions_m.size(), glm::vec3(0.0f));
    boxes.push_back(BoundingBoxOf(object.mesh));
  }
  of_unit_ = irradiance_;
  if (!IsGathered()) {
    needed_probes_ = ProbesNeededIn(scene_.probes.Grid(), scene_.probes.Valid(), boxes);
  }
  gather_ = ObjectGather();
  is_coarse_ = false;
  near_sunlight_.reset();
  single_probe_.Pose(interreflection_.Objects().mesh);
  // Light that follows the objects stays in use until the next step.
  if (follows_) {
    responses_[0].done.Invalidate();
  } else {
    responses_[0] = {};
  }
  responses_[1] = responses_[2] = {};
  objects_sun_id_ = {};
  daylight_response_.clear();
  daylight_done_ = {};
  vertices_.clear();
}

const SingleProbeLight& VertexLight::LightAtSingleProbe(const FrameBasis& basis,
                                                        const Lighting& lighting) {
  single_probe_.UpdateOthers(basis, lighting);
  return single_probe_;
}

VertexLight::Costs VertexLight::Expected(const Mode& mode,
                                         const FrameBasis& basis,
                                         const Lighting& lighting) const {
  Costs costs = CostsBy(&LearnedCost::Ms, mode, basis, lighting);
  if (LacksRaysBetween(mode)) costs.once_ms += between_cost_.Ms();
  const std::vector<std::size_t> lacking = Done(mode).StaleIn(basis, lighting, Refresh::kMissing);
  if (!IsGathered() || lacking.empty()) return costs;
  if (mode.at == At::kVertices && follows_) {
    costs.once_ms = follow_cost_.Ms();
    return costs;
  }
  if (mode.at == At::kVertices && gather_.VertexCount() == 0) costs.once_ms += set_up_cost_.Ms();
  if (LooksForSun(mode, lacking)) costs.once_ms += near_cost_.Ms();
  return costs;
}

bool VertexLight::LacksRaysBetween(const Mode& mode) const {
  const bool meets_objects = IsGathered() && mode.at == At::kVertices;
  return mode.with_objects && !meets_objects && !interreflection_.HasCastRays();
}

bool VertexLight::LooksForSun(const Mode& mode, const std::vector<std::size_t>& lights) const {
  const bool sees_objects = mode.at == At::kVertices || mode.with_objects;
  return sees_objects && !lights.empty() && lights.front() == 0 && !near_sunlight_ &&
         scene_.options.bounces != 0;
}

VertexLight::Costs VertexLight::Nominal(const Mode& mode,
                                        const FrameBasis& basis,
                                        const Lighting& lighting) const {
  return CostsBy(&LearnedCost::NominalMs, mode, basis, lighting);
}

VertexLight::Costs VertexLight::CostsBy(double (LearnedCost::*ms)() const,
                                        const Mode& mode,
                                        const FrameBasis& basis,
                                        const Lighting& lighting) const {
  const LightsDone& done = Done(mode);
  const double light_ms = (light_costs_[WayOf(mode)].*ms)();
  const auto lacking = static_cast<double>(done.StaleIn(basis, lighting, Refresh::kMissing).size());
  const auto all = static_cast<double>(done.StaleIn(basis, lighting).size());
  return {lacking * light_ms, (all - lacking) * light_ms, (sum_cost_.*ms)()};
}

const SkyShape& VertexLight::GatheredSky(const FrameBasis& basis, std::size_t light) const {
  static const std::shared_ptr<const SkyShape> black =
      MakeTableSkyShape("black", std::vector<glm::vec3>(SkyTable::kCells, glm::vec3(0.0f)));
  return daylight_ != nullptr ? *black : *basis.Sky(light);
}

bool VertexLight::IsDaylightCurrent(const FrameBasis& basis) const {
  if (daylight_ == nullptr) return true;
  const auto shapes = basis.Shapes();
  return std::equal(shapes.begin(), shapes.end(), sampled_shapes_.begin(), sampled_shapes_.end());
}

void VertexLight::UpdateDaylight(const FrameBasis& basis) {
  if (IsDaylightCurrent(basis)) return;
  const auto shapes = basis.Shapes();
  Stopwatch watch;
  sampled_shapes_.clear();
  daylight_->Update(shapes);
  daylight_cost_.Learn(watch.LapMs());
  sampled_shapes_.assign(shapes.begin(), shapes.end());
  daylight_is_new_ = true;
}

void VertexLight::UpdateDaylightResponses(const FrameBasis& basis) {
  if (daylight_ == nullptr) return;
  UpdateDaylight(basis);
  daylight_response_.resize(basis.LightCount());
  for (std::size_t light = 1; light < basis.LightCount(); ++light) {
    if (daylight_done_.IsCurrent(basis, light)) continue;
    daylight_response_[light] = WithReflection(light, daylight_->OnObjects(light - 1));
    daylight_done_.Done(basis, light);
  }
}

glm::vec3 VertexLight::LargestDaylight(const FrameBasis& basis, const Lighting& lighting) const {
  glm::vec3 largest(0.0f);
  if (daylight_ == nullptr) return largest;
  for (std::size_t light = 1; light < basis.LightCount(); ++light) {
    const glm::vec3 intensity = IntensityOf(lighting, light);
    if (intensity == glm::vec3(0.0f)) continue;
    largest += intensity * daylight_->LargestIrradiance(basis.Shapes()[light - 1]);
  }
  return largest;
}

std::optional<DirectDaylightSummary> VertexLight::TakeDaylightSummary() {
  if (daylight_ == nullptr) return std::nullopt;
  DirectDaylightSummary summary = daylight_->Summary();
  if (!std::exchange(daylight_is_new_, false)) summary.maps_drawn = 0;
  return summary;
}

void VertexLight::Update(Mode mode,
                         Refresh refresh,
                         const FrameBasis& basis,
                         const Lighting& lighting) {
  mode_ = mode;
  const At at = mode.at;
  const std::vector<std::size_t> stale = Done(mode).StaleIn(basis, lighting, refresh);
  const PatchScene& objects = interreflection_.Objects();
  Stopwatch watch;
  if (LacksRaysBetween(mode)) {
    interreflection_.CastRays();
    between_cost_.Learn(watch.LapMs());
  }
  // Faces are lit by the sun that light is made for.
  const bool makes_sun = !stale.empty() && stale.front() == 0;
  if ((makes_sun || !objects_sun_id_.IsSet() || refresh == Refresh::kStale) &&
      objects_sun_id_ != basis.LightId(0) && IntensityOf(lighting, 0) != glm::vec3(0.0f)) {
    interreflection_.UpdateSun(scene_.patches.caster, basis.BounceSun().direction_enu);
    objects_sun_id_ = basis.LightId(0);
  }
  if (!IsGathered()) {
    if (!stale.empty() || basis_.sky_radiance.size() != basis.LightCount()) {
      UpdateVolume(basis, stale);
      light_costs_[WayOf(mode)].Learn(watch.LapMs() /
                                      static_cast<double>(std::max<std::size_t>(stale.size(), 1)));
    }
    return;
  }
  if (stale.empty()) return;
  if (at == At::kVertices && follows_) {
    const bool goes_on = Follow(basis, stale);
    follow_cost_.Learn(watch.LapMs());
    if (goes_on) {
      for (const std::size_t light : stale) responses_[0].done.Done(basis, light);
      return;
    }
  }
  if (at == At::kVertices && gather_.VertexCount() == 0) {
    is_coarse_ = MayStartCoarse();
    GatherOptions gather = options_.gather;
    if (is_coarse_) gather.rays_per_receiver = options_.in_motion.rays_at_first;
    gather_ = ObjectGather(objects, scene_.patches, gather);
    SmoothThisShape();
    if (!is_coarse_) set_up_cost_.Learn(watch.LapMs());
  }
  if (LooksForSun(mode, stale)) {
    NearSunlightOptions near;
    if (is_coarse_) {
      near.rays_per_receiver = std::max(
          1, near.rays_per_receiver * gather_.RaysPerVertex() / options_.gather.rays_per_receiver);
    }
    near_sunlight_.emplace(scene_.patches, objects, ObjectGather::PointsAround(objects.mesh), near);
    if (!is_coarse_) near_cost_.Learn(watch.LapMs());
  }
  Responses& responses = Of(mode);
  responses.of_light.resize(basis.LightCount());
  if (at == At::kSingleProbe) single_probe_.Update(basis, lighting);
  for (const std::size_t light : stale) {
    if (at == At::kVertices) {
      UpdateGathered(basis, light);
    } else {
      responses.of_light[light] = mode.with_objects ? AtSingleProbeWithObjects(basis, light)
                                                    : single_probe_.OnObjects(light);
    }
    responses.done.Done(basis, light);
  }
  light_costs_[WayOf(mode)].Learn(watch.LapMs() / static_cast<double>(stale.size()));
}

// Map, sky directions and fold of what has changed; at first of all lights.
void VertexLight::UpdateVolume(const FrameBasis& basis, std::span<const std::size_t> lights) {
  const Survey* survey = basis.SurveyUnderCurrentSun();
  const std::vector<glm::vec3>& directions = scene_.probes.SkyDirections();
  const bool is_first = basis_.sky_radiance.size() != basis.LightCount();
  std::vector<std::size_t> wanted(lights.begin(), lights.end());
  if (is_first) {
    basis_ = {};
    basis_.environment.resize(basis.LightCount());
    basis_.face_radiosity.resize(basis.LightCount());
    basis_.sky_radiance.resize(basis.LightCount());
    basis_.sky_radiance[0].assign(directions.size(), glm::vec3(0.0f));
    wanted.clear();
    for (std::size_t light = 0; light < basis.LightCount(); ++light) wanted.push_back(light);
  }
  for (const std::size_t light : wanted) {
    basis_.face_radiosity[light] = basis.FaceRadiosity(light);
    if (survey != nullptr) {
      basis_.environment[light] =
          light == 0 ? EnvironmentOfSun(*survey, survey->view.sun_direction_enu)
                     : EnvironmentOfSky(*survey, light - 1, GatheredSky(basis, light));
    }
    if (light == 0) continue;
    basis_.sky_radiance[light].clear();
    for (const glm::vec3& direction : directions) {
      basis_.sky_radiance[light].push_back(GatheredSky(basis, light).Radiance(direction));
    }
  }
  if (is_first) {
    folded_ = FoldedVolume(scene_.probes, basis_);
  } else {
    for (const std::size_t light : wanted) folded_.Refold(scene_.probes, basis_, light);
  }
  for (const std::size_t light : wanted) folded_done_.Done(basis, light);
}

void VertexLight::SmoothThisShape() {
  const Mesh& mesh = interreflection_.Objects().mesh;
  std::vector<float> hidden_share(mesh.positions_m.size(), 0.0f);
  tbb::parallel_for(std::size_t{0}, hidden_share.size(), [&](std::size_t v) {
    float& share = hidden_share[v];
    gather_.ForSources(
        v,
        [&](const glm::vec3&, std::size_t, float of_object) { share += of_object; },
        [](const glm::vec3&, float) {});
    constexpr float kMostOutside = 0.999f;  // 1 means within an object.
    share = gather_.IsBuried(v) ? 1.0f : std::min(share, kMostOutside);
  });
  smoothing_ = VertexSmoothing(mesh, hidden_share, gather_.RaysPerVertex());
}

void VertexLight::Smooth(std::size_t light) {
  Responses& responses = responses_[0];
  responses.smoothed.resize(responses.of_light.size());
  responses.smoothed[light] = smoothing_.Smoothed(responses.of_light[light]);
}

void VertexLight::UpdateGathered(const FrameBasis& basis, std::size_t light) {
  const PatchScene& objects = interreflection_.Objects();
  const std::vector<glm::vec3> dark_objects(objects.FaceCount(), glm::vec3(0.0f));
  std::vector<glm::vec3> irradiance = gather_.Irradiance(
      IsSampled(light) ? nullptr : basis.Sky(light), dark_objects, basis.FaceRadiosity(light));
  if (light == 0) {
    AddNearSunlight(
        basis,
        [this](std::span<const glm::vec3> at_points) { return gather_.AtVertices(at_points); },
        irradiance);
  }
  Of(mode_).of_light[light] = WithReflection(light, std::move(irradiance));
  Smooth(light);
}

template <class AtVertices>
void VertexLight::AddNearSunlight(const FrameBasis& basis,
                                  const AtVertices& at_vertices,
                                  std::vector<glm::vec3>& irradiance) {
  if (!near_sunlight_) return;
  const std::vector<glm::vec3> change = at_vertices(near_sunlight_->Change(
      scene_.patches, interreflection_.Objects(), basis.BounceSun(), basis.DirectIrradiance()));
  for (std::size_t v = 0; v < irradiance.size(); ++v) {
    // Both are estimates by few rays: their sum may fall below zero.
    irradiance[v] = glm::max(irradiance[v] + change[v], glm::vec3(0.0f));
  }
}

std::vector<glm::vec3> VertexLight::AtSingleProbeWithObjects(const FrameBasis& basis,
                                                             std::size_t light) {
  std::vector<glm::vec3> irradiance = single_probe_.OnObjects(light);
  if (light == 0) {
    const auto mean_of_points = [](std::span<const glm::vec3> at_points) {
      constexpr std::size_t kPoints = ObjectGather::kPointsPerVertex;
      std::vector<glm::vec3> means(at_points.size() / kPoints, glm::vec3(0.0f));
      for (std::size_t i = 0; i < at_points.size(); ++i) {
        means[i / kPoints] += at_points[i] / static_cast<float>(kPoints);
      }
      return means;
    };
    AddNearSunlight(basis, mean_of_points, irradiance);
  }
  SpreadOverObjects(irradiance);
  DirectionalLight sun;
  if (light == 0) sun.irradiance_rgb = glm::dvec3(1.0);
  interreflection_.Apply(sun, of_unit_);
  std::vector<glm::vec3> response;
  for (const std::vector<glm::vec3>& of_object : of_unit_) {
    response.insert(response.end(), of_object.begin(), of_object.end());
  }
  return response;
}

void VertexLight::SpreadOverObjects(const std::vector<glm::vec3>& irradiance) {
  std::size_t first = 0;
  for (std::vector<glm::vec3>& of_object : of_unit_) {
    std::copy_n(irradiance.begin() + static_cast<std::ptrdiff_t>(first),
                of_object.size(),
                of_object.begin());
    first += of_object.size();
  }
}

std::vector<glm::vec3> VertexLight::WithReflection(std::size_t light,
                                                   std::vector<glm::vec3> irradiance) {
  SpreadOverObjects(irradiance);
  DirectionalLight sun;
  if (light == 0) sun.irradiance_rgb = glm::dvec3(1.0);
  const std::vector<glm::vec3> dark_scene(scene_.patches.FaceCount(), glm::vec3(0.0f));
  const std::vector<glm::vec3> reflected =
      gather_.Irradiance(nullptr, interreflection_.FaceRadiosity(sun, of_unit_), dark_scene);
  for (std::size_t v = 0; v < irradiance.size(); ++v) irradiance[v] += reflected[v];
  return irradiance;
}

void VertexLight::SumResponses(const FrameBasis& basis, const Lighting& lighting, PerObject& sum) {
  if (mode_.with_daylight) UpdateDaylightResponses(basis);
  const Responses& of_mode = Of(mode_);
  const std::vector<std::vector<glm::vec3>>& responses =
      of_mode.smoothed.empty() ? of_mode.of_light : of_mode.smoothed;
  std::size_t first = 0;
  for (std::vector<glm::vec3>& irradiance : sum) {
    std::fill(irradiance.begin(), irradiance.end(), glm::vec3(0.0f));
    const auto add = [&](const std::vector<glm::vec3>& response, const glm::vec3& intensity) {
      if (response.empty()) return;
      const auto own = std::span(response).subspan(first, irradiance.size());
      for (std::size_t v = 0; v < irradiance.size(); ++v) irradiance[v] += intensity * own[v];
    };
    for (std::size_t light = 0; light < basis.LightCount(); ++light) {
      const glm::vec3 intensity = IntensityOf(lighting, light);
      if (intensity == glm::vec3(0.0f) || light >= responses.size()) continue;
      add(responses[light], intensity);
      if (mode_.with_daylight && IsSampled(light)) add(daylight_response_[light], intensity);
    }
    first += irradiance.size();
  }
}

std::vector<glm::vec3> VertexLight::DirectAtVertices(const FrameBasis& basis,
                                                     const Lighting& lighting) {
  std::vector<glm::vec3> direct;
  if (daylight_ == nullptr) return direct;
  UpdateDaylight(basis);
  direct.assign(interreflection_.Objects().mesh.positions_m.size(), glm::vec3(0.0f));
  for (std::size_t light = 1; light < basis.LightCount(); ++light) {
    const glm::vec3 intensity = IntensityOf(lighting, light);
    if (intensity == glm::vec3(0.0f)) continue;
    const std::vector<glm::vec3>& of_unit = daylight_->OnObjects(light - 1);
    for (std::size_t v = 0; v < direct.size(); ++v) direct[v] += intensity * of_unit[v];
  }
  return direct;
}

void VertexLight::LightVertices(const IrradianceVolume& volume,
                                const FrameBasis& basis,
                                const Lighting& lighting,
                                PerObject& sum) {
  if (vertices_.empty()) {
    for (const VirtualObject& object : *objects_) {
      vertices_.emplace_back(volume, object.mesh.positions_m, object.mesh.normals);
    }
  }
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    vertices_[i].Evaluate(volume, sum[i]);
  }
  const std::vector<glm::vec3> direct =
      mode_.with_daylight ? DirectAtVertices(basis, lighting) : std::vector<glm::vec3>();
  if (mode_.with_objects) {
    interreflection_.Apply(lighting.sun, sum, direct);
    return;
  }
  auto own = direct.begin();
  for (std::vector<glm::vec3>& irradiance : sum) {
    for (std::size_t v = 0; v < irradiance.size() && own != direct.end(); ++v) {
      irradiance[v] += *own++;
    }
  }
}

std::vector<glm::vec3> VertexLight::ObjectRadiosity(const FrameBasis& basis, std::size_t light) {
  const Lighting unit = UnitOf(light, basis.LightCount());
  if (!IsGathered()) {
    folded_.Combine(unit, needed_probes_, volume_of_unit_);
    LightVertices(volume_of_unit_, basis, unit, of_unit_);
  } else {
    SumResponses(basis, unit, of_unit_);
  }
  return interreflection_.FaceRadiosity(unit.sun, of_unit_);
}

std::vector<glm::vec3> VertexLight::SampledSkyHiddenFrom(const FrameBasis& basis,
                                                         std::size_t light,
                                                         std::span<const Receiver> receivers) {
  if (!IsSampled(light) || !mode_.with_daylight) return {};
  UpdateDaylight(basis);
  return daylight_->HiddenFrom(light - 1, receivers);
}

void VertexLight::Evaluate(const FrameBasis& basis, const Lighting& lighting) {
  Stopwatch watch;
  if (IsGathered()) {
    SumResponses(basis, lighting, irradiance_);
  } else {
    if (options_.route == ObjectLight::kVolumeByMap) {
      Stopwatch making;
      SynthesiseEnvironment(basis_.environment, lighting, environment_);
      environment_ms_ += making.LapMs();
      volume_ = VolumeFromEnvironment(scene_.probes, basis_, environment_, lighting);
    } else {
      folded_.Combine(lighting, needed_probes_, volume_);
    }
    LightVertices(volume_, basis, lighting, irradiance_);
  }
  sum_cost_.Learn(watch.LapMs());
}

}  // namespace pleinair
