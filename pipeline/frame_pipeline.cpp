#include "pipeline/frame_pipeline.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <stdexcept>
#include <string>
#include <utility>

#include "pipeline/frame_view.h"

namespace pleinair {
namespace {

// Milliseconds since construction or the last lap.
class Stopwatch {
 public:
  double LapMs() {
    const auto now = std::chrono::steady_clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
    return ms;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

const SurveyLight* LightOf(const PreparedScene& scene) {
  return scene.survey ? &scene.survey->light : nullptr;
}

std::optional<SurveyedLight> SurveyedLightOf(const PreparedScene& scene) {
  if (!scene.survey || !scene.survey_time) return std::nullopt;
  const SurveyLight& light = scene.survey->light;
  return SurveyedLight{*scene.survey_time,
                       light.sun_irradiance_rgb,
                       light.sun_irradiance_stddev_rgb,
                       light.sky_irradiance_rgb};
}

}  // namespace

void FramePipelineOptions::Validate() const {
  if (!(sun_step_s >= 0.0) || !std::isfinite(sun_step_s)) {
    throw std::invalid_argument("sun_step_s " + std::to_string(sun_step_s) +
                                ": expected 0 or more seconds");
  }
  if (daylight == Daylight::kSamples) direct_daylight.Validate();
  influence.Validate();
  soft_sun.Validate();
  mirror.Validate();
}

FramePipeline::FramePipeline(const PreparedScene& scene,
                             const Mesh& phantom,
                             std::optional<Site> site,
                             std::vector<VirtualObject> objects,
                             std::unique_ptr<LightingSource> source,
                             Compositor& compositor,
                             const FramePipelineOptions& options)
    : scene_(scene),
      site_(site),
      objects_(std::move(objects)),
      source_(std::move(source)),
      compositor_(compositor),
      options_(options),
      camera_matching_(options.camera_matching),
      clear_sky_(site_, LightOf(scene)),
      view_builder_(scene, options.view),
      interreflection_(objects_.Objects()),
      real_caster_(phantom) {
  options_.Validate();
  const bool has_objects = !objects_.Objects().empty();
  if (options_.daylight == Daylight::kSamples && has_objects) {
    room_ = phantom;
    SampleDaylight();
  }
  if (options_.effects.sun_shadow && options_.effects.penumbra && has_objects) {
    soft_sun_.emplace(real_caster_, interreflection_.Objects(), options_.soft_sun);
  }
  has_mirrors_ = options_.effects.glossy_reflection && IsGlossy(interreflection_.Objects().mesh);
  if (options_.filter) filter_.emplace(*options_.filter);
  compositor_.SetPhantom(phantom);
  compositor_.SetObjects(objects_.Objects());
  for (const VirtualObject& object : objects_.Objects()) {
    vertex_irradiance_.emplace_back(object.mesh.positions_m.size(), glm::vec3(0.0f));
  }
}

tl::expected<FrameResult, FrameError> FramePipeline::Process(
    const Frame& frame, std::span<const glm::dmat4> object_poses) {
  const auto failed = [&](std::string reason) {
    return tl::unexpected(FrameError{frame.index, frame.time, std::move(reason)});
  };
  try {
    FrameResult result;
    result.sun = SunOfFrame(site_, frame);
    result.clear_sky = clear_sky_.At(result.sun.direction_enu);
    const SunState transport_sun = TransportSun(site_, frame, result.sun, options_.sun_step_s);

    transport_sun_ = {transport_sun.direction_enu, {}, transport_sun.angular_radius_rad};

    Stopwatch watch;
    const auto basis = source_->BasisFor(frame, transport_sun);
    if (!basis) return failed(basis.error().reason);
    sky_shapes_.assign(basis->begin(), basis->end());
    const SurfaceView& view = view_builder_.Update(frame.camera,
                                                   transport_sun.direction_enu,
                                                   transport_sun.angular_radius_rad,
                                                   sky_shapes_,
                                                   SampleRegionsOf(frame));
    const bool new_sun = basis_sun_version_ != view_builder_.SunFacesVersion();
    const bool new_light = new_sun || basis_shapes_ != sky_shapes_;
    if (!objects_.Objects().empty()) {
      PoseObjects(object_poses);
      if (new_light) {
        UpdateBasis(new_sun);
        if (options_.object_light != ObjectLight::kGather) UpdateVolume();
      } else {
        changed_lights_.clear();
      }
      if (daylight_ != nullptr && (new_light || objects_moved_)) daylight_->Update(sky_shapes_);
      if (new_sun || objects_moved_) {
        interreflection_.UpdateSun(scene_.patches.caster, transport_sun.direction_enu);
      }
      UpdateObjects(view);
      UpdateSunShares(view);
    }
    const bool moved = std::exchange(objects_moved_, false);
    result.timing_ms.transport = watch.LapMs();

    auto estimate = source_->Estimate({frame,
                                       view,
                                       result.sun,
                                       result.clear_sky,
                                       std::nullopt,
                                       scene_.albedo_stddev_rgb,
                                       SurveyedLightOf(scene_)});
    if (!estimate) return failed(estimate.error().reason);
    result.estimate = std::move(*estimate);
    FilterEstimate(result);
    result.timing_ms.estimate = watch.LapMs() - result.estimate.new_sample_set_ms;
    result.timing_ms.transport += result.estimate.new_sample_set_ms;

    if (daylight_ != nullptr) {
      result.daylight = daylight_->Summary();
      if (!new_light && !moved) result.daylight->maps_drawn = 0;
    }

    if (!objects_.Objects().empty()) Shade(result.estimate.lighting, result.timing_ms);
    result.composite = compositor_.Render({frame.radiance,
                                           frame.clipped,
                                           view,
                                           result.estimate.lighting,
                                           vertex_irradiance_,
                                           options_.effects,
                                           &irradiance_change_,
                                           soft_sun_ ? &sun_shares_ : nullptr,
                                           has_mirrors_ ? &mirrored_ : nullptr,
                                           camera_matching_.ObjectBlurPx(frame, view)});
    camera_matching_.AddNoise(frame, options_.display_response, result.composite);
    result.timing_ms.render = result.composite.draw_ms;
    result.timing_ms.readback = result.composite.readback_ms;
    return result;
  } catch (const std::exception& error) {
    // What was half done is done anew.
    basis_sun_version_.reset();
    basis_shapes_.clear();
    influence_geometry_version_.reset();
    object_view_version_.reset();
    sun_shares_version_.reset();
    mirror_version_.reset();
    return failed(error.what());
  }
}

void FramePipeline::SampleDaylight() {
  daylight_ = std::make_unique<DirectDaylight>(
      room_, scene_.patches.caster, interreflection_.Objects(), options_.direct_daylight);
}

void FramePipeline::PoseObjects(std::span<const glm::dmat4> world_from_given) {
  if (!objects_.Pose(world_from_given)) return;
  objects_moved_ = true;
  compositor_.SetObjects(objects_.Objects());
  interreflection_ = ObjectInterreflection(objects_.Objects());
  if (daylight_ != nullptr) SampleDaylight();
  gather_ = ObjectGather();
  vertices_.clear();
  needed_probes_.clear();
  influence_geometry_version_.reset();
  object_view_version_.reset();
  sun_shares_version_.reset();
  mirror_version_.reset();
}

RgbImage FramePipeline::EnvironmentRadiance(const EnvironmentView& view,
                                            const Lighting& lighting) const {
  const FaceLight& sun = view_builder_.SunFaces();
  std::vector<EnvironmentLight> basis{{nullptr, sun.radiosity, sun.direct_irradiance}};
  for (std::size_t k = 0; k < sky_shapes_.size(); ++k) {
    basis.push_back({sky_shapes_[k].get(), view_builder_.SkyFaces(k).radiosity, {}});
  }
  return view.Radiance(lighting, basis);
}

std::string FramePipeline::DaylightNote() const {
  return daylight_ != nullptr ? daylight_->Note() : std::string();
}

void FramePipeline::FilterEstimate(FrameResult& result) {
  result.raw_lighting = result.estimate.lighting;
  if (!filter_) return;
  FilteredLighting filtered = filter_->Apply(result.raw_lighting, result.estimate.units);
  const glm::dvec3 raw_sky = result.raw_lighting.SkyIrradianceRgb();
  const glm::dvec3 sky = filtered.lighting.SkyIrradianceRgb();
  for (glm::dvec3& region : result.estimate.sky_radiance_rgb) {
    for (int c = 0; c < 3; ++c) region[c] *= raw_sky[c] > 0.0 ? sky[c] / raw_sky[c] : 1.0;
  }
  result.estimate.lighting = std::move(filtered.lighting);
  result.sun_filter = filtered.sun;
  result.sky_filter = filtered.sky;
}

void FramePipeline::UpdateBasis(bool new_sun) {
  changed_lights_.clear();
  if (new_sun) changed_lights_.push_back(0);
  for (std::size_t k = 0; k < sky_shapes_.size(); ++k) {
    if (k >= basis_shapes_.size() || basis_shapes_[k] != sky_shapes_[k]) {
      changed_lights_.push_back(1 + k);
    }
  }
  basis_.face_radiosity.resize(1 + sky_shapes_.size());
  for (const std::size_t light : changed_lights_) {
    basis_.face_radiosity[light] = light == 0 ? view_builder_.SunFaces().radiosity
                                              : view_builder_.SkyFaces(light - 1).radiosity;
  }
  basis_sun_version_ = view_builder_.SunFacesVersion();
  basis_shapes_ = sky_shapes_;
}

// Map, sky directions and fold of what has changed.
void FramePipeline::UpdateVolume() {
  const Survey* survey = view_builder_.SurveyUnderCurrentSun();
  const std::vector<glm::vec3>& directions = scene_.probes.SkyDirections();
  const bool first = basis_.sky_radiance.empty();
  basis_.environment.resize(basis_.face_radiosity.size());
  basis_.sky_radiance.resize(basis_.face_radiosity.size());
  basis_.sky_radiance[0].assign(directions.size(), glm::vec3(0.0f));
  for (const std::size_t light : changed_lights_) {
    if (survey != nullptr) {
      basis_.environment[light] =
          light == 0 ? EnvironmentOfSun(*survey, survey->view.sun_direction_enu)
                     : EnvironmentOfSky(*survey, light - 1, GatheredSky(light - 1));
    }
    if (light == 0) continue;
    basis_.sky_radiance[light].clear();
    for (const glm::vec3& direction : directions) {
      basis_.sky_radiance[light].push_back(GatheredSky(light - 1).Radiance(direction));
    }
  }
  if (first) {
    folded_ = FoldedVolume(scene_.probes, basis_);
  } else {
    for (const std::size_t light : changed_lights_) folded_.Refold(scene_.probes, basis_, light);
  }
}

// What a unit of each light that has changed makes of the objects, and they of the real scene.
void FramePipeline::UpdateObjects(const SurfaceView& view) {
  if (options_.object_light != ObjectLight::kGather && needed_probes_.empty()) {
    std::vector<BoundingBox> boxes;
    for (const VirtualObject& object : objects_.Objects()) {
      boxes.push_back(BoundingBoxOf(object.mesh));
    }
    needed_probes_ = ProbesNeededIn(scene_.probes.Grid(), scene_.probes.Valid(), boxes);
  }
  const bool has_influence = options_.effects.sky_occlusion || options_.effects.colour_bleeding;
  const bool new_view = has_influence && influence_geometry_version_ != view.geometry_version;
  const bool on_faces = options_.influence_at == InfluenceAt::kFaces;
  const bool new_influence = new_view && (!on_faces || !influence_geometry_version_);
  if (new_influence) {
    influence_ =
        on_faces
            ? ObjectInfluence(scene_.patches, interreflection_.Objects(), options_.influence)
            : ObjectInfluence(scene_.patches, interreflection_.Objects(), view, options_.influence);
  }
  if (new_view && on_faces) influence_.See(scene_.patches, view, view_builder_.PixelFaces());
  if (new_view) influence_geometry_version_ = view.geometry_version;
  const bool new_mirror = has_mirrors_ && mirror_version_ != view.geometry_version;
  if (new_mirror) {
    UpdateObjectView(view);
    mirror_ = MirrorImage(scene_.patches,
                          interreflection_.Objects(),
                          object_view_,
                          scene_.survey ? &*scene_.survey : nullptr,
                          options_.mirror);
    mirror_version_ = view.geometry_version;
  }
  if (!new_influence && !new_mirror && !objects_moved_ && changed_lights_.empty()) return;
  const std::vector<Receiver> receivers =
      has_influence && daylight_ != nullptr ? influence_.Receivers() : std::vector<Receiver>();
  vertex_response_.resize(basis_.face_radiosity.size());
  for (std::size_t light = 0; light < basis_.face_radiosity.size(); ++light) {
    const bool changed =
        objects_moved_ ||
        std::find(changed_lights_.begin(), changed_lights_.end(), light) != changed_lights_.end();
    if (!changed && !new_influence && !new_mirror) continue;
    Lighting unit;
    unit.sky.resize(sky_shapes_.size());
    (light == 0 ? unit.sun.irradiance_rgb : unit.sky[light - 1].irradiance_rgb) = glm::dvec3(1.0);
    if (options_.object_light != ObjectLight::kGather) {
      folded_.Combine(unit, needed_probes_, volume_);
      LightVertices(volume_, unit);
    } else {
      if (changed) vertex_response_[light] = GatherAtVertices(light);
      SumVertexResponses(unit);
    }
    const std::vector<glm::vec3> object_radiosity =
        interreflection_.FaceRadiosity(unit.sun, vertex_irradiance_);
    if (has_mirrors_ && (changed || new_mirror)) FoldMirror(light, object_radiosity);
    if (!has_influence || (!changed && !new_influence)) continue;
    const bool sampled = light > 0 && daylight_ != nullptr;
    influence_.Fold(
        light,
        light == 0 || sampled ? nullptr : sky_shapes_[light - 1].get(),
        view,
        basis_.face_radiosity[light],
        object_radiosity,
        sampled ? daylight_->HiddenFrom(light - 1, receivers) : std::vector<glm::vec3>());
  }
}

void FramePipeline::UpdateObjectView(const SurfaceView& view) {
  if (object_view_version_ == view.geometry_version) return;
  object_view_ = SeeObjects(interreflection_.Objects(), view.camera);
  object_view_version_ = view.geometry_version;
}

void FramePipeline::FoldMirror(std::size_t light, std::span<const glm::vec3> object_radiosity) {
  MirroredBasis basis;
  basis.sky = light == 0 ? nullptr : sky_shapes_[light - 1].get();
  basis.real_radiosity = basis_.face_radiosity[light];
  basis.object_radiosity = object_radiosity;
  if (light == 0) basis.real_direct = view_builder_.SunFaces().direct_irradiance;
  basis.sun = transport_sun_;
  mirror_.Fold(light, basis, scene_.patches, interreflection_.Objects());
}

void FramePipeline::UpdateSunShares(const SurfaceView& view) {
  if (!soft_sun_) return;
  UpdateObjectView(view);
  if (sun_shares_version_ == view.sun_version) return;
  sun_shares_ = {soft_sun_->OnReal(view, transport_sun_),
                 soft_sun_->OnObjects(object_view_, transport_sun_)};
  sun_shares_version_ = view.sun_version;
}

// Under a unit of one light, one reflection off the objects included.
std::vector<glm::vec3> FramePipeline::GatherAtVertices(std::size_t light) {
  const PatchScene& objects = interreflection_.Objects();
  if (gather_.VertexCount() == 0) {
    gather_ = ObjectGather(objects, scene_.patches, options_.object_gather);
  }
  const bool sampled = light > 0 && daylight_ != nullptr;
  const SkyShape* sky = light == 0 || sampled ? nullptr : sky_shapes_[light - 1].get();
  const std::vector<glm::vec3> dark_objects(objects.FaceCount(), glm::vec3(0.0f));
  std::vector<glm::vec3> irradiance =
      gather_.Irradiance(sky, dark_objects, basis_.face_radiosity[light]);
  if (sampled) {
    const std::vector<glm::vec3>& direct = daylight_->OnObjects(light - 1);
    for (std::size_t v = 0; v < irradiance.size(); ++v) irradiance[v] += direct[v];
  }
  if (light == 0 && scene_.options.bounces != 0) {
    const std::vector<glm::vec3> change = gather_.NearSunlightChange(
        objects, scene_.patches, transport_sun_, view_builder_.SunFaces().direct_irradiance);
    for (std::size_t v = 0; v < irradiance.size(); ++v) {
      // Both are estimates by few rays: their sum may fall below zero.
      irradiance[v] = glm::max(irradiance[v] + change[v], glm::vec3(0.0f));
    }
  }

  vertex_response_[light] = irradiance;
  Lighting unit;
  unit.sky.resize(sky_shapes_.size());
  (light == 0 ? unit.sun.irradiance_rgb : unit.sky[light - 1].irradiance_rgb) = glm::dvec3(1.0);
  SumVertexResponses(unit);
  const std::vector<glm::vec3> dark_scene(scene_.patches.FaceCount(), glm::vec3(0.0f));
  const std::vector<glm::vec3> reflected = gather_.Irradiance(
      nullptr, interreflection_.FaceRadiosity(unit.sun, vertex_irradiance_), dark_scene);
  for (std::size_t v = 0; v < irradiance.size(); ++v) irradiance[v] += reflected[v];
  return irradiance;
}

void FramePipeline::SumVertexResponses(const Lighting& lighting) {
  std::size_t first = 0;
  for (std::vector<glm::vec3>& irradiance : vertex_irradiance_) {
    std::fill(irradiance.begin(), irradiance.end(), glm::vec3(0.0f));
    for (std::size_t light = 0; light < vertex_response_.size(); ++light) {
      const glm::vec3 intensity(light == 0 ? lighting.sun.irradiance_rgb
                                           : lighting.sky[light - 1].irradiance_rgb);
      if (vertex_response_[light].empty() || intensity == glm::vec3(0.0f)) continue;
      const std::span<const glm::vec3> response =
          std::span(vertex_response_[light]).subspan(first, irradiance.size());
      for (std::size_t v = 0; v < irradiance.size(); ++v) irradiance[v] += intensity * response[v];
    }
    first += irradiance.size();
  }
}

const SkyShape& FramePipeline::GatheredSky(std::size_t k) const {
  static const std::shared_ptr<const SkyShape> black =
      MakeTableSkyShape("black", std::vector<glm::vec3>(SkyTable::kCells, glm::vec3(0.0f)));
  return daylight_ != nullptr ? *black : *sky_shapes_[k];
}

std::vector<glm::vec3> FramePipeline::DirectAtVertices(const Lighting& lighting) const {
  std::vector<glm::vec3> direct;
  if (daylight_ == nullptr) return direct;
  direct.assign(interreflection_.Objects().mesh.positions_m.size(), glm::vec3(0.0f));
  for (std::size_t k = 0; k < lighting.sky.size(); ++k) {
    const glm::vec3 intensity(lighting.sky[k].irradiance_rgb);
    if (intensity == glm::vec3(0.0f)) continue;
    const std::vector<glm::vec3>& of_unit = daylight_->OnObjects(k);
    for (std::size_t v = 0; v < direct.size(); ++v) direct[v] += intensity * of_unit[v];
  }
  return direct;
}

void FramePipeline::LightVertices(const IrradianceVolume& volume, const Lighting& lighting) {
  if (vertices_.empty()) {
    for (const VirtualObject& object : objects_.Objects()) {
      vertices_.emplace_back(volume, object.mesh.positions_m, object.mesh.normals);
    }
  }
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    vertices_[i].Evaluate(volume, vertex_irradiance_[i]);
  }
  interreflection_.Apply(lighting.sun, vertex_irradiance_, DirectAtVertices(lighting));
}

void FramePipeline::Shade(const Lighting& lighting, StageTimes& times) {
  Stopwatch watch;
  if (options_.object_light == ObjectLight::kGather) {
    SumVertexResponses(lighting);
  } else {
    if (options_.object_light == ObjectLight::kVolumeByMap) {
      SynthesiseEnvironment(basis_.environment, lighting, environment_);
      times.relight = watch.LapMs();
      volume_ = VolumeFromEnvironment(scene_.probes, basis_, environment_, lighting);
    } else {
      folded_.Combine(lighting, needed_probes_, volume_);
    }
    LightVertices(volume_, lighting);
  }
  if (has_mirrors_) mirror_.Evaluate(lighting, mirrored_);
  influence_.Evaluate(lighting,
                      {.hidden_light = options_.effects.sky_occlusion,
                       .object_light = options_.effects.colour_bleeding},
                      irradiance_change_);
  times.probes = watch.LapMs();
}

}  // namespace pleinair
